// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/front_loops.h"

namespace stroma {

const FrontKernels front_kernels_v3 = loops;

}  // namespace stroma
