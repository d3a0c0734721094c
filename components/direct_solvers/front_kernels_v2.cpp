// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/front_loops.h"
#include "components/direct_solvers/side_loops.h"

namespace stroma {

const FrontKernels front_kernels_v2 = loops;
const AllSideKernels side_kernels_v2 = side_loops;

}  // namespace stroma
