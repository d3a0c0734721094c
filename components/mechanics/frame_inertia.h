// SPDX-License-Identifier: LGPL-2.1-or-later
// The inertia of rigid frames, as attributes of a mass.
#pragma once
#include "framework/mechanics/mass.h"

namespace stroma {

class FrameInertia {
 public:
  void declare(DataTable& table);  ///< inertia
  /// Of each frame, or one for all, [kg m^2]; without the attribute as many as `masses`, each m `per_mass`. Throws
  /// ComponentError for what no body can have.
  std::vector<Mat3> tensors(const Component& mass, const State& state, const std::vector<double>& masses,
                            const Mat3& per_mass) const;
  /// What rows have of nodes with these masses [kg]: frames also of `tensors`, one for all or for each; those that are not
  /// alike about all axes go to `turning`.
  static std::vector<double> ofRows(const State& state, const std::vector<double>& masses,
                                    const std::vector<Mat3>& tensors, std::vector<TurningInertia>& turning);

 private:
  std::vector<double> inertia_;
};

/// A matrix from nine numbers, row by row.
Mat3 matrixOf(const double* numbers);

}  // namespace stroma
