// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/motion.h"

namespace stroma {

/// For loops that add several increments: the orientations of a vector, taken out of it. Who adds keeps one from step to
/// step, which allocates the first time alone.
class Orientations {
 public:
  /// Takes them out of x and leaves zeros, on which rotation vectors are added up as everything is.
  void take(const Motion& motion, Rows x) {
    turning_ = &motion.turningRows();
    q_.resize(turning_->size() * row_doubles);
    forEachIn(x, [](double* row, double* q) {
      Four from(row), to(q);
      to = from;
      from.setZero();
    });
  }
  /// Puts them into x, turned by what has come together there; into several vectors, if several are made of the one.
  void turn(Rows x) {
    forEachIn(x, [](double* row, const double* q) {
      const Vec3 r(row[0], row[1], row[2]);
      Four to(row);
      to = Eigen::Map<const Eigen::Vector4d>(q);
      Motion::turnBy(r, row);
    });
  }

 private:
  using Four = Eigen::Map<Eigen::Vector4d>;
  template <class Visit>
  void forEachIn(Rows x, Visit&& visit) {
    for (std::size_t i = 0; i < turning_->size() && (*turning_)[i] < x.count; ++i)
      visit(x.data + std::size_t((*turning_)[i]) * row_doubles, q_.data() + i * row_doubles);
  }

  const std::vector<Index>* turning_ = nullptr;
  std::vector<double> q_;  ///< shape (turning rows, 4)
};

}  // namespace stroma
