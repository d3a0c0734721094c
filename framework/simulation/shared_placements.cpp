// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/shared_placements.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "framework/mechanics/frames.h"

namespace stroma {

void SharedPlacements::add(int constraint, const NodeProjector* begin, const NodeProjector* end) {
  for (const NodeProjector* node = begin; node != end; ++node)
    entries_.push_back({node->row, constraint, Mat3::Identity() - node->projector, Eigen::Vector4d::Zero(), Vec3::Zero()});
}

void SharedPlacements::keepShared() {
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.row != b.row ? a.row < b.row : a.constraint < b.constraint; });
  std::size_t kept = 0;
  for (auto first = entries_.cbegin(); first != entries_.cend();) {
    const auto last = endOfRow(first);
    if (first->constraint != std::prev(last)->constraint)
      for (auto entry = first; entry != last; ++entry) entries_[kept++] = *entry;
    first = last;
  }
  entries_.erase(entries_.begin() + std::ptrdiff_t(kept), entries_.end());
}

SharedPlacements::Iterator SharedPlacements::endOfRow(Iterator first) const {
  return std::find_if(first, entries_.cend(), [&](const Entry& entry) { return entry.row != first->row; });
}

void SharedPlacements::note(int constraint, ConstRows x, ConstRows v) {
  for (Entry& entry : entries_)
    if (entry.constraint == constraint) {
      entry.x = Eigen::Map<const Eigen::Vector4d>(x.data + std::size_t(entry.row) * row_doubles);
      entry.v = v[entry.row];
    }
}

SharedPlacements::Conflict SharedPlacements::meet(const Motion& motion, Rows x, Rows v) const {
  constexpr double parallel = 1e-7;  // as where projectors are merged: directions that differ by less are one
  Conflict worst;
  for (auto first = entries_.cbegin(); first != entries_.cend();) {
    const auto last = endOfRow(first);
    const bool turns = motion.kindOf(first->row) == RowKind::turn;
    const auto wayTo = [&](const Entry& entry) {
      if (!turns) return Vec3(entry.x.head<3>() - Vec3(x[first->row]));
      return rotationVector(Quaternion(entry.x) * orientationIn(x, first->row).conjugate());
    };
    const Vec3 v_now = v[first->row];
    Mat3 held = Mat3::Zero();
    Vec3 to_x = Vec3::Zero(), to_v = Vec3::Zero();
    double size = turns ? 1 : Vec3(x[first->row]).norm();
    for (auto entry = first; entry != last; ++entry) {
      held += entry->held;
      to_x += entry->held * wayTo(*entry);
      to_v += entry->held * (entry->v - v_now);
      size = std::max(size, entry->x.head<3>().norm());
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(held);
    const Vec3 inverse = (eigen.eigenvalues().array() > parallel).select(1 / eigen.eigenvalues().array(), Eigen::Array3d::Zero());
    const Mat3 pseudo_inverse = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
    motion.advanceRow(pseudo_inverse * to_x, x, first->row);
    for (int again = 0; turns && again < 100; ++again) {  // increments of turns do not add up
      Vec3 left = Vec3::Zero();
      for (auto entry = first; entry != last; ++entry) left += entry->held * wayTo(*entry);
      if (left.norm() < 1e-15) break;
      motion.advanceRow(pseudo_inverse * left, x, first->row);
    }
    v[first->row] = v_now + pseudo_inverse * to_v;
    for (auto entry = first; entry != last; ++entry) {
      const double distance = (entry->held * wayTo(*entry)).norm();
      if (distance <= std::max(1e-9 * size, worst.distance)) continue;
      const auto other = entry == first ? std::prev(last) : first;
      worst = {first->row, entry->constraint, other->constraint, distance};
    }
    first = last;
  }
  return worst;
}

}  // namespace stroma
