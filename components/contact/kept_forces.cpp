// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/kept_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "framework/scene/archive.h"

namespace stroma::contact {

namespace {

/// What is nearest to each corner; of an obtuse triangle half for its largest corner and a quarter for each other.
std::array<double, 3> nearestTo(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> p{a, b, c};
  const double area = 0.5 * (b - a).cross(c - a).norm();
  std::array<double, 3> shares{}, cosines{};
  for (std::size_t k = 0; k < 3; ++k) cosines[k] = (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]);
  for (std::size_t k = 0; k < 3; ++k)
    if (cosines[k] < 0) {
      shares.fill(area / 4), shares[k] = area / 2;
      return shares;
    }
  if (!(area > 0)) return shares;
  for (std::size_t k = 0; k < 3; ++k)  // |p_k p_i|^2 cot_j / 8 and |p_k p_j|^2 cot_i / 8, cot = cosine / (2 area)
    for (const auto& [i, j] : {std::pair((k + 1) % 3, (k + 2) % 3), std::pair((k + 2) % 3, (k + 1) % 3)})
      shares[k] += (p[k] - p[i]).squaredNorm() * cosines[j] / (16 * area);
  return shares;
}

}  // namespace

void KeptForces::compile(const Surfaces& surfaces, std::vector<char> rigid) {
  rigid_ = std::move(rigid);
  shares_.assign(surfaces.faces.size(), {0, 0, 0});
  const auto at = [&](int v) -> const Vec3& { return surfaces.rest[std::size_t(v)]; };
  for (std::size_t t = 0; t < shares_.size(); ++t) {
    const auto& [a, b, c] = surfaces.faces[t];
    if (rigid_[std::size_t(surfaces.bodyOf(a))]) shares_[t] = nearestTo(at(a), at(b), at(c));
  }
}

KeptForces::Name KeptForces::nameOf(const KeptGap& gap) {
  if (!gap.pair) return {2, gap.v[0], int(gap.plane)};
  return {int(gap.pair->kind), gap.pair->first, gap.pair->second};
}

void KeptForces::take(const KeptGaps& gaps, const Surfaces& surfaces, std::span<const double> forces, std::size_t each) {
  clear(), pushed_.clear();
  for (std::size_t i = 0; i < gaps.all().size(); ++i)
    if (forces[each * i] > 0 && isRigid(gaps.all()[i], surfaces)) pushed_.push_back(i);
  std::ranges::sort(pushed_, {}, [&](std::size_t i) { return nameOf(gaps.all()[i]); });
  for (const std::size_t i : pushed_) {
    const KeptGap& gap = gaps.all()[i];
    const double* l = forces.data() + each * i;
    names_.push_back(nameOf(gap));
    forces_.push_back(l[0] * gap.n + (each == 3 ? Vec3(l[1] * gap.tangent + l[2] * gap.n.cross(gap.tangent)) : Vec3(Vec3::Zero())));
  }
}

bool KeptForces::isRigid(const KeptGap& gap, const Surfaces& surfaces) const {
  if (!rigid_[std::size_t(surfaces.bodyOf(gap.v[0]))]) return false;
  return !gap.pair || rigid_[std::size_t(surfaces.bodyOf(gap.v[3]))];
}

/// That of the faces which look `towards`.
double KeptForces::areaAt(int vertex, const Vec3& towards, const Surfaces& s, const std::vector<Vec3>& x) const {
  constexpr double along = 0.9;
  double seen = 0, all = 0;
  for (Index i = s.faces_around.start[std::size_t(vertex)]; i < s.faces_around.start[std::size_t(vertex) + 1]; ++i) {
    const auto t = std::size_t(s.faces_around.values[std::size_t(i)]);
    const auto& [a, b, c] = s.faces[t];
    const Vec3 normal = (x[std::size_t(b)] - x[std::size_t(a)]).cross(x[std::size_t(c)] - x[std::size_t(a)]);
    const double share = shares_[t][vertex == a ? 0 : vertex == b ? 1 : 2];
    all += share;
    if (std::abs(normal.dot(towards)) > along * normal.norm()) seen += share;
  }
  return seen > 0 ? seen : all;
}

double KeptForces::areaOf(const KeptGap& gap, const Surfaces& s, const std::vector<Vec3>& x) const {
  if (!gap.pair || gap.pair->kind == PairKind::point_triangle) return areaAt(gap.v[0], gap.n, s, x);
  double sum = 0;
  for (const int v : gap.v) sum += areaAt(v, gap.n, s, x) / 4;
  return sum;
}

void KeptForces::expect(const KeptGaps& gaps, const Surfaces& surfaces, const std::vector<Vec3>& x, std::size_t each,
                        std::span<double> forces, std::span<double> yields) const {
  for (std::size_t i = 0; i < gaps.all().size(); ++i) {
    const KeptGap& gap = gaps.all()[i];
    if (!gap.is_active || !isRigid(gap, surfaces)) continue;
    const double area = areaOf(gap, surfaces, x);
    if (area > 0) std::fill_n(yields.begin() + std::ptrdiff_t(each * i), each, 1 / area);
    const auto known = std::ranges::lower_bound(names_, nameOf(gap));
    if (known == names_.end() || *known != nameOf(gap)) continue;
    const Vec3& force = forces_[std::size_t(known - names_.begin())];
    forces[each * i] = std::max(0.0, gap.n.dot(force));
    if (each == 3) forces[each * i + 1] = gap.tangent.dot(force), forces[each * i + 2] = gap.n.cross(gap.tangent).dot(force);
  }
}

bool KeptForces::isViolated(const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, std::size_t each,
                       std::span<const double> forces, double friction, double tolerated) const {
  constexpr double all = 0.999;  // of what friction can be
  for (std::size_t i = 0; i < gaps.all().size(); ++i) {
    const KeptGap& gap = gaps.all()[i];
    if (!gap.is_active || !isRigid(gap, law.surfaces)) continue;
    const double* l = forces.data() + each * i;
    if (gap.gap < -tolerated || (l[0] > 0 && gap.gap > tolerated)) return true;
    if (each == 1 || !(std::hypot(l[1], l[2]) < all * friction * l[0])) continue;
    const Vec3 slid = gaps.slide(gap, law, x);
    if ((slid - gap.n * gap.n.dot(slid)).norm() > tolerated) return true;
  }
  return false;
}

void KeptForces::serialize(Archive& archive) {
  std::vector<int> numbers;
  for (const Name& name : names_) numbers.insert(numbers.end(), name.begin(), name.end());
  archive.list("pushed_pairs", numbers);
  archive.list("pair_forces", forces_);
  if (numbers.size() != 3 * forces_.size()) numbers.clear(), forces_.clear();  // of no use without each other
  names_.resize(numbers.size() / 3);
  for (std::size_t i = 0; i < names_.size(); ++i) std::copy_n(numbers.begin() + std::ptrdiff_t(3 * i), 3, names_[i].begin());
}

}  // namespace stroma::contact
