// SPDX-License-Identifier: LGPL-2.1-or-later
// A real number of each volume cell of a mesh file, as materials take them: a Young's modulus that a program has found from
// computed tomography.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "framework/mesh/cell_lists.h"
#include "framework/scene/component.h"

namespace stroma {

struct CellValues {
  std::string array;  ///< its name in the file; empty: none
  double factor = 1;
  PerCellList<std::vector<double>> lists;

  /// The attributes valueArray, valueFactor, tetrahedraValues and its like.
  void declare(DataTable& table) {
    table.add("valueArray", array).help("cell data of one real number that go to tetrahedraValues and its like");
    table.add("valueFactor", factor).unit("-").help("of them, as 1e6 for a modulus that the file has in MPa");
    forEachCellList(
        [&table](const CellKind& kind, std::vector<double>& values) {
          if (kind.dimension < 3) return;
          table.add(fmt::format("{}Values", kind.plural), values)
              .help(fmt::format("valueArray of each {}, as youngModulus takes them", kind.singular))
              .output();
        },
        lists);
  }
  /// Throws ComponentError for what is no number.
  void add(std::vector<double>& values, double value) const {
    if (!std::isfinite(value))
      throw ComponentError(fmt::format("the cell data '{}' have the value {} at volume cell {}", array, value, values.size()),
                           "finite numbers");
    values.push_back(factor * value);
  }
};

}  // namespace stroma
