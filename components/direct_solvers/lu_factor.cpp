// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/lu_factor.h"

#include <Eigen/SparseLU>

#include "components/direct_solvers/eigen_factor.h"

namespace stroma {
namespace {

using LU = Eigen::SparseLU<SparseCopy::Matrix>;

class EigenLUFactor final : public EigenFactor<LU, SolveStop::breakdown, LUFactor> {
 public:
  Cost cost() const override { return {5e-8 * entries(), 1e-9 * entries()}; }
  double entries() const override { return double(solver_.nnzL() + solver_.nnzU()); }
};

}  // namespace

std::unique_ptr<LUFactor> LUFactor::make() { return std::make_unique<EigenLUFactor>(); }

}  // namespace stroma
