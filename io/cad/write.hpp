// SPDX-License-Identifier: MIT
//
// assembly.json and a PLY file of each shape; README.md of this folder tells their format.
#ifndef CAD_WRITE_HPP
#define CAD_WRITE_HPP

#include "assembly.hpp"

namespace cad
{

// Makes the folder; one that has something in it is refused. assembly.json comes last.
void write_assembly(const Options &options, const Assembly &assembly);

} // namespace cad

#endif
