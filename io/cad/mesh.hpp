// SPDX-License-Identifier: MIT
//
// The mesh of one body: OpenCASCADE's triangles face by face, joined along the edges that faces
// share, with vertices put on the true surfaces that meet in them.
#ifndef CAD_MESH_HPP
#define CAD_MESH_HPP

#include "assembly.hpp"

namespace cad
{

struct MeshReport {
    std::size_t empty_faces = 0, open_edges = 0;
    double off = 0; // the farthest that a vertex lies from a true surface of its own
    bool turned = false;
};

// Fills shape.mesh of shape.brep, shape.chord and shape.faces (their brep and surface); turns it
// outward if it is closed.
MeshReport make_mesh(Shape &shape, double angle);

} // namespace cad

#endif
