// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/side_solves.h"

#include <string>

#include "framework/scene/modules.h"

namespace stroma {
namespace {

const AllSideKernels& sideKernelsOfThisMachine() {
  static const std::string level = instructionLevel();
  return level == "x86-64-v4" ? side_kernels_v4 : level == "x86-64-v3" ? side_kernels_v3 : side_kernels_v2;
}

}  // namespace

template <>
const SideKernels<float>& sideKernels() {
  return sideKernelsOfThisMachine().in_single;
}
template <>
const SideKernels<double>& sideKernels() {
  return sideKernelsOfThisMachine().in_double;
}

std::vector<int> parentsOf(const SupernodalPattern& pattern) {
  std::vector<int> owner(std::size_t(pattern.columns)), parent;
  for (int s = 0; s < pattern.count; ++s)
    std::fill(owner.begin() + pattern.first[s], owner.begin() + pattern.first[s + 1], s);
  for (int s = 0; s < pattern.count; ++s) {
    const int columns = pattern.columnsOf(s);
    parent.push_back(pattern.heightOf(s) > columns ? owner[std::size_t(pattern.rowsOf(s)[columns])] : -1);
  }
  return parent;
}

}  // namespace stroma
