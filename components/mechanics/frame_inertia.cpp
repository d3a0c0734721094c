// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mechanics/frame_inertia.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

namespace stroma {

Mat3 matrixOf(const double* numbers) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers); }

void FrameInertia::declare(DataTable& table) {
  table.add("inertia", inertia_)
      .unit("kg m^2")
      .help("of a rigid frame about its centre, in its axes: three numbers about its axes or nine, of all or of each");
}

namespace {

/// A real body has moments whose sums of two are no less than the third.
void check(const Mat3& tensor, std::size_t frame, const Component& mass) {
  if (!(tensor - tensor.transpose()).isZero(1e-9 * tensor.norm()))
    throw ComponentError(fmt::format("the inertia of frame {} is not symmetric", frame), "a symmetric matrix");
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(moments[0] > 0))
    throw ComponentError(fmt::format("the inertia of frame {} has the principal moments {:.4g} {:.4g} {:.4g}", frame,
                                     moments[0], moments[1], moments[2]),
                         "three positive ones");
  if (moments[0] + moments[1] < moments[2] * (1 - 1e-6))
    mass.warn(
        fmt::format("no body has the principal moments {:.4g} {:.4g} {:.4g} of frame {}: two of them together are "
                    "less than the third",
                    moments[0], moments[1], moments[2], frame));
}

}  // namespace

std::vector<Mat3> FrameInertia::tensors(const Component& mass, const State& state, const std::vector<double>& masses,
                                        const Mat3& per_mass) const {
  std::vector<Mat3> tensors;
  const std::size_t frames = std::size_t(state.nodes()), count = inertia_.size();
  if (count == 0) {
    for (const double m : masses) tensors.push_back(m * per_mass);
  } else if (count == 3 || (count == 3 * frames && count != 9)) {
    for (std::size_t i = 0; i < count; i += 3)
      tensors.push_back(Vec3(inertia_[i], inertia_[i + 1], inertia_[i + 2]).asDiagonal());
  } else if (count == 9 || count == 9 * frames) {
    for (std::size_t i = 0; i < count; i += 9) tensors.push_back(matrixOf(inertia_.data() + i));
  } else {
    throw ComponentError(fmt::format("inertia has {} numbers for {} frames", count, frames),
                         "3 (principal moments) or 9 numbers (a matrix), or as many for each frame");
  }
  for (std::size_t i = 0; i < tensors.size(); ++i)
    if (count > 0 || masses[i] > 0) check(tensors[i], i, mass);
  return tensors;
}

std::vector<double> FrameInertia::ofRows(const State& state, const std::vector<double>& masses,
                                         const std::vector<Mat3>& tensors, std::vector<TurningInertia>& turning) {
  std::vector<double> rows(std::size_t(state.size()));
  for (Index row = 0; row < state.size(); ++row) {
    const std::size_t node = std::size_t(row / state.rows_per_node);
    rows[std::size_t(row)] = masses[node];
    if (state.kindOf(row) != RowKind::turn) continue;
    const Mat3 tensor = masses[node] > 0 ? tensors[tensors.size() == 1 ? 0 : node] : Mat3(Mat3::Zero());
    const double mean = tensor.trace() / 3;
    rows[std::size_t(row)] = mean;
    if (!(tensor - mean * Mat3::Identity()).isZero(1e-14 * mean)) turning.push_back({row, tensor});
  }
  return rows;
}

}  // namespace stroma
