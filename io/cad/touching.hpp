// SPDX-License-Identifier: MIT
//
// Parts that touch: faces of two parts that lie on one surface, against each other, over an area.
#ifndef CAD_TOUCHING_HPP
#define CAD_TOUCHING_HPP

#include "assembly.hpp"
#include "progress.hpp"

namespace cad
{

// Fills assembly.touching, in the order of the parts.
void find_touching(Assembly &assembly, Progress &progress);

} // namespace cad

#endif
