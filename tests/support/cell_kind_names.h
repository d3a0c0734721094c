// SPDX-License-Identifier: LGPL-2.1-or-later
// Names of tests of kinds of cells, which else have addresses in them.
#pragma once
#include <ostream>

#include "framework/mesh/cell_kind.h"

namespace stroma {

inline void PrintTo(const CellKind* kind, std::ostream* out) { *out << kind->singular; }

}  // namespace stroma
