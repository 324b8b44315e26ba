// SPDX-License-Identifier: MIT
//
// The true surface of a face: plane, cylinder, cone, sphere or torus, named as such in the file or
// found to be one.
#ifndef CAD_SURFACE_HPP
#define CAD_SURFACE_HPP

#include "assembly.hpp"

namespace cad
{

// How far a surface may be from the true one that stands for it, in mm.
constexpr double exactness = 1e-9;

struct Sample {
    gp_XYZ point, normal;
};

// Signed distance to the surface (0 on `none`) and its unit gradient there; on the axis, where
// there is none, false.
bool distance(const Surface &surface, const gp_XYZ &point, double &value, gp_XYZ &gradient);

Surface surface_of(const TopoDS_Face &face);

// The surface of a kind on which all samples lie, `none` where there is none. minor: of a torus,
// its small radius, with the sign by which the normal points from the middle of its tube.
Surface fit_surface(const std::vector<Sample> &samples, double minor);

// Rotated, moved (and scaled) as places say.
Surface placed(const Surface &surface, const gp_Trsf &place);

// Whether the two are one surface, within a length and an angle; two of no kind are not told apart.
bool same_surface(const Surface &a, const Surface &b, double tolerance, double angle);

} // namespace cad

#endif
