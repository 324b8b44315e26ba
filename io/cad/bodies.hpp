// SPDX-License-Identifier: MIT
//
// The bodies of one product, and their exact measures.
#ifndef CAD_BODIES_HPP
#define CAD_BODIES_HPP

#include "document.hpp"

namespace cad
{

struct Body {
    TopoDS_Shape shape;
    std::string name;
    bool sewn = false;             // of faces that shared no edges in the file
    ByShape<const void *> sources; // of a sewn face: the face of the file

    // What names and colours of a face are found by.
    const void *source_of(const TopoDS_Shape &face) const;
};

// Solids; of what is in none, shells. What shares no edges and closes when it is sewn, is.
std::vector<Body> bodies_of(const TopoDS_Shape &product, const Document &document);

// Volume, areas, middles and moments by integration over the exact faces.
void measure(Shape &shape);

// `hash`: the same for the same geometry in the same place of its frame; `form`: wherever it lies,
// mirrored or not. Both from the exact surfaces, rounded to 1e-7 of the size.
void sign(Shape &shape);

// What OpenCASCADE's own check says of the body, or "".
std::string faults_of(const TopoDS_Shape &shape, const Document &document);

// Whether b is a copy of a, moved or mirrored as `place` then says.
bool copy_of(const Shape &a, const Shape &b, gp_Trsf &place);

} // namespace cad

#endif
