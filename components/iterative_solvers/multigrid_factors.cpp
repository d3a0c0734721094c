// SPDX-License-Identifier: LGPL-2.1-or-later
// What a hierarchy factors, the last level and patches, for nodes and for groups of them: half of what the compiler would
// take for multigrid_hierarchy.cpp.
#include "components/iterative_solvers/multigrid_hierarchy.h"
#include "components/iterative_solvers/multigrid_patch_build.h"

namespace stroma::amg {

template double LastLevel::layOut(const BlockView<3>&);
template double LastLevel::layOut(const BlockView<modes>&);
template bool LastLevel::factorShifted(const BlockView<3>&, double, double);
template bool LastLevel::factorShifted(const BlockView<modes>&, double, double);
template void LastLevel::solve<3>(const float*, float*);
template void LastLevel::solve<modes>(const float*, float*);
template bool addPatches(const BlockView<3>&, double, bool, Level<3>&);
template bool addPatches(const BlockView<modes>&, double, bool, Level<modes>&);

bool hardlySmooths(const BlockMatrix& a) {
  const BlockView<3> view{a.rows(), a.rowStart().data(), a.columns().data(), a.diagonal().data(), a.values().data()};
  Patches<3> patches;
  return PatchMaker<3>(view, 1, patches).leastSeenUsually() < hardly_seen;
}

}  // namespace stroma::amg
