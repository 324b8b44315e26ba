// SPDX-License-Identifier: MIT
//
// The tree of parts of a document, with the shapes that they share.
#ifndef CAD_TREE_HPP
#define CAD_TREE_HPP

#include "document.hpp"

namespace cad
{

// Fills assembly.parts and assembly.shapes (names, bodies, meshes, measures, hashes).
void build_tree(const Options &options, const Document &document, Assembly &assembly,
                Progress &progress);

} // namespace cad

#endif
