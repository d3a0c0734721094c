// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/force_measure.h"

#include <cmath>

namespace stroma {

void ForceMeasure::take(const SystemMatrix& matrix) {
  if (!motion_) return;
  matrix.diagonalBlocks(blocks_);
  const auto trace = [&](Index row) {
    const double* const block = blocks_.data() + std::size_t(row) * 9;
    return block[0] + block[4] + block[8];
  };
  double logarithms = 0;
  long frames = 0;
  for (Index row = 1; row < matrix.rows(); ++row) {
    if (motion_->kindOf(row) != RowKind::turn || motion_->kindOf(row - 1) != RowKind::place) continue;
    const double ratio = std::log(trace(row)) - std::log(trace(row - 1));
    if (std::isfinite(ratio)) logarithms += 0.5 * ratio, ++frames;
  }
  if (frames > 0) length_ = std::exp(logarithms / double(frames));
}

double ForceMeasure::sum(ConstRows rows, double turns) const {
  double sum = 0;
  for (Index row = 0; row < rows.count; ++row)
    sum += rows[row].squaredNorm() * (motion_->kindOf(row) == RowKind::turn ? turns * turns : 1);
  return std::sqrt(sum);
}

}  // namespace stroma
