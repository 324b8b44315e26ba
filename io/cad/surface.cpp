// SPDX-License-Identifier: MIT
#include "surface.hpp"

#include <BRepAdaptor_Surface.hxx>
#include <BRepLProp_SLProps.hxx>
#include <BRepTools.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

#include <algorithm>
#include <cmath>

namespace cad
{

const char *name_of(Kind kind)
{
    static const char *const names[] = {"none", "plane", "cylinder", "cone", "sphere", "torus"};
    return names[static_cast<int>(kind)];
}

bool distance(const Surface &surface, const gp_XYZ &point, double &value, gp_XYZ &gradient)
{
    const gp_XYZ from = point - surface.origin;
    const double along = from * surface.axis;
    const gp_XYZ across = from - surface.axis * along;
    const double rho = across.Modulus();
    value = 0;
    gradient = gp_XYZ(0, 0, 0);
    if (surface.kind == Kind::none)
        return false;
    if (surface.kind == Kind::plane) {
        value = along;
        gradient = surface.axis;
        return true;
    }
    if (surface.kind == Kind::sphere) {
        const double radius = from.Modulus();
        value = radius - surface.radius1;
        gradient = radius > 0 ? from / radius : gradient;
        return radius > 0;
    }
    const gp_XYZ outward = rho > 0 ? across / rho : gradient;
    if (surface.kind == Kind::cylinder) {
        value = rho - surface.radius1;
        gradient = outward;
    } else if (surface.kind == Kind::cone) {
        const double c = std::cos(surface.radius2), s = std::sin(surface.radius2);
        value = (rho - surface.radius1) * c - along * s;
        gradient = outward * c - surface.axis * s;
    } else {
        const double ring = rho - surface.radius1, radius = std::hypot(ring, along);
        value = radius - surface.radius2;
        if (radius > 0)
            gradient = (outward * ring + surface.axis * along) / radius;
        return rho > 0 && radius > 0;
    }
    return rho > 0;
}

Surface placed(const Surface &surface, const gp_Trsf &place)
{
    const double scale = std::abs(place.ScaleFactor());
    Surface out = surface;
    place.Transforms(out.origin);
    out.axis = gp_Vec(surface.axis).Transformed(place).XYZ().Normalized();
    out.radius1 *= scale;
    if (surface.kind != Kind::cone)
        out.radius2 *= scale;
    return out;
}

bool same_surface(const Surface &a, const Surface &b, double tolerance, double angle)
{
    if (a.kind != b.kind ||
        std::abs(a.radius1 - b.radius1) > (a.kind == Kind::cone ? 1e300 : tolerance) ||
        std::abs(std::abs(a.radius2) - std::abs(b.radius2)) >
            (a.kind == Kind::cone ? angle : tolerance))
        return false;
    if (a.kind == Kind::none)
        return true;
    if (a.kind == Kind::sphere)
        return (a.origin - b.origin).Modulus() <= tolerance;
    const gp_XYZ between = b.origin - a.origin;
    if ((a.axis ^ b.axis).Modulus() > angle)
        return false;
    if (a.kind == Kind::plane)
        return std::abs(between * a.axis) <= tolerance;
    if ((between - a.axis * (between * a.axis)).Modulus() > tolerance)
        return false;
    if (a.kind == Kind::torus)
        return std::abs(between * a.axis) <= tolerance;
    const auto apex = [](const Surface &cone) {
        return cone.origin - cone.axis * (cone.radius1 / std::tan(cone.radius2));
    };
    return a.kind != Kind::cone || ((apex(a) - apex(b)).Modulus() <= 100 * tolerance &&
                                    a.radius2 * b.radius2 * (a.axis * b.axis) > 0);
}

static std::vector<Sample> samples_of(const BRepAdaptor_Surface &surface, double &minor)
{
    constexpr int n = 11; // odd: knots in the middle of a domain are met
    std::vector<Sample> samples;
    double spread[2] = {0, 0}, mean[2] = {0, 0}, curvatures[2][n * n];
    int curved = 0;
    const double u0 = surface.FirstUParameter(), du = surface.LastUParameter() - u0;
    const double v0 = surface.FirstVParameter(), dv = surface.LastVParameter() - v0;
    double widest = 0;
    std::array<std::array<gp_Vec, 2>, n * n> tangents;
    std::array<gp_Pnt, n * n> points;
    for (std::size_t k = 0; k < n * n; ++k) {
        surface.D1(u0 + du * static_cast<double>(k / n) / (n - 1),
                   v0 + dv * static_cast<double>(k % n) / (n - 1), points[k], tangents[k][0],
                   tangents[k][1]);
        widest = std::max(widest, (tangents[k][0] ^ tangents[k][1]).Magnitude());
    }
    for (std::size_t k = 0; k < n * n; ++k) {
        const gp_Vec normal = tangents[k][0] ^ tangents[k][1];
        if (!(normal.Magnitude() > 1e-4 * widest)) // a pole
            continue;
        samples.push_back({points[k].XYZ(), normal.XYZ().Normalized()});
        BRepLProp_SLProps at(surface, u0 + du * static_cast<double>(k / n) / (n - 1),
                             v0 + dv * static_cast<double>(k % n) / (n - 1), 2, 1e-12);
        if (!at.IsCurvatureDefined())
            continue;
        curvatures[0][curved] = at.MaxCurvature();
        curvatures[1][curved++] = at.MinCurvature();
    }
    minor = 0;
    for (int k = 0; k < 2 && curved > 0; ++k) {
        for (int i = 0; i < curved; ++i)
            mean[k] += curvatures[k][i] / curved;
        for (int i = 0; i < curved; ++i)
            spread[k] = std::max(spread[k], std::abs(curvatures[k][i] - mean[k]));
    }
    const int steady =
        spread[0] < spread[1] ? 0 : 1; // of a torus one curvature is the same everywhere
    if (curved > 0 && std::abs(mean[steady]) > 0)
        minor = -1 / mean[steady]; // curvature > 0 bends towards the normal
    return samples;
}

static bool holds(const Surface &surface, const std::vector<Sample> &samples)
{
    for (const Sample &sample : samples) {
        double value;
        gp_XYZ gradient;
        if (distance(surface, sample.point, value, gradient) &&
            std::abs(gradient * sample.normal) < 1 - 1e-9)
            return false;
        if (!(std::abs(value) <= exactness))
            return false;
    }
    return !samples.empty();
}

Surface surface_of(const TopoDS_Face &face)
{
    Surface out;
    const BRepAdaptor_Surface surface(face);
    switch (surface.GetType()) {
    case GeomAbs_Plane:
        return {Kind::plane, surface.Plane().Location().XYZ(),
                surface.Plane().Axis().Direction().XYZ()};
    case GeomAbs_Cylinder: {
        const gp_Cylinder it = surface.Cylinder();
        return {Kind::cylinder, it.Location().XYZ(), it.Axis().Direction().XYZ(), it.Radius()};
    }
    case GeomAbs_Cone: {
        const gp_Cone it = surface.Cone();
        return {Kind::cone, it.Location().XYZ(), it.Axis().Direction().XYZ(), it.RefRadius(),
                it.SemiAngle()};
    }
    case GeomAbs_Sphere:
        return {Kind::sphere, surface.Sphere().Location().XYZ(), gp_XYZ(0, 0, 1),
                surface.Sphere().Radius()};
    case GeomAbs_Torus: {
        const gp_Torus it = surface.Torus();
        out = {Kind::torus, it.Location().XYZ(), it.Axis().Direction().XYZ(), it.MajorRadius(),
               it.MinorRadius()};
        return out.radius2 < out.radius1
                   ? out
                   : Surface(); // one that crosses itself is left to triangles
    }
    default:
        break;
    }
    double minor = 0;
    const std::vector<Sample> samples = samples_of(surface, minor);
    out = fit_surface(samples, minor);
    return holds(out, samples) ? out : Surface();
}

} // namespace cad
