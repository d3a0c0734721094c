// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/frame_pair_field.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

namespace {

Vec3 vectorOf(const Triple<double>& a) { return {a.x, a.y, a.z}; }

// ---- lanes to packs and back ----

Pack packOf(const std::array<double, std::size_t(pack_lanes)>& lanes) { return Pack::load_aligned(lanes.data()); }
template <class Lanes>
V3<Pack> vectorIn(const Lanes& lanes, std::size_t first = 0) {
  return {packOf(lanes[first]), packOf(lanes[first + 1]), packOf(lanes[first + 2])};
}
template <class Lanes>
void put(const V3<Pack>& v, Lanes& lanes, std::size_t first = 0) {
  v.x.store_aligned(lanes[first].data()), v.y.store_aligned(lanes[first + 1].data()), v.z.store_aligned(lanes[first + 2].data());
}
template <class Lanes>
M3<Pack> axesIn(const Lanes& lanes) {
  return {vectorIn(lanes, 0), vectorIn(lanes, 3), vectorIn(lanes, 6)};
}
Orientation<Pack> orientationsAt(const double* data, const Index* offset) {
  alignas(64) std::array<double, std::size_t(pack_lanes)> w;
  for (std::size_t lane = 0; lane < w.size(); ++lane) w[lane] = data[offset[lane] + 3];
  return {gatherRows(data, offset), packOf(w)};
}

}  // namespace

void FramePairField::setPairs(std::vector<Pair> pairs, State* second) {
  second_ = second == &state() ? nullptr : second;
  for (const State* each : {&state(), &this->second()})
    if (!each->hasFrames())
      throw ComponentError(fmt::format("{} has no frames", each->path()), "a state of template Rigid3");
  pairs_ = std::move(pairs);
  damped_ = false;
  for (const Pair& pair : pairs_) damped_ = damped_ || pair.damping > 0;
}

std::vector<State*> FramePairField::states() const {
  return second_ ? std::vector<State*>{&state(), second_} : std::vector<State*>{&state()};
}

ForceTraits FramePairField::traits() const {
  ForceTraits traits;
  traits.symmetric = traits.conservative = true;
  traits.velocity_dependent = damped_;
  return traits;
}

void FramePairField::compile() {
  std::vector<Group> rows;
  for (const Pair& pair : pairs_) {
    const Index a = state().firstRow() + pair.a, b = second().firstRow() + pair.b;
    rows.push_back({a, a + 1, b, b + 1});
  }
  setGroups(std::move(rows), damped_);
  const std::size_t lanes = std::size_t(pack_lanes), count = (pairs_.size() + lanes - 1) / lanes;
  fixed_.resize(count);
  for (std::size_t i = 0; i < count * lanes; ++i) {
    Fixed& fixed = fixed_[i / lanes];
    const std::size_t lane = i % lanes, last = std::min(i, pairs_.size() - 1);
    for (std::size_t k = 0; k < 4; ++k) {
      fixed.rows[k][lane] = rows_[last][k] * row_doubles;
      fixed.axes_a[k][lane] = pairs_[last].axes_a.coeffs()[Index(k)];
      fixed.axes_b[k][lane] = pairs_[last].axes_b.coeffs()[Index(k)];
    }
  }
  for (std::vector<Batch>* batches : {&batches_, &work_batches_}) batches->assign(count, {});
}

void FramePairField::place(ConstRows x, std::vector<Batch>& batches) const {
  for (std::size_t i = 0; i < batches.size(); ++i) {
    const Fixed& fixed = fixed_[i];
    Batch& batch = batches[i];
    const Orientation<Pack> axes_a{vectorIn(fixed.axes_a), packOf(fixed.axes_a[3])},
        axes_b{vectorIn(fixed.axes_b), packOf(fixed.axes_b[3])};
    const Orientation<Pack> a = orientationsAt(x.data, fixed.rows[1].data()) * axes_a;
    const Orientation<Pack> b = orientationsAt(x.data, fixed.rows[3].data()) * axes_b;
    const V3<Pack> arm = gatherRows(x.data, fixed.rows[2].data()) - gatherRows(x.data, fixed.rows[0].data());
    const M3<Pack> axes = a.axes();
    const V3<Pack> psi = (a.conjugate() * b).logarithm();
    const InverseTerm<Pack> term(dot(psi, psi));
    put(axes.c0, batch.axes, 0), put(axes.c1, batch.axes, 3), put(axes.c2, batch.axes, 6);
    put(arm, batch.arm), put(transposedTimes(axes, arm), batch.p), put(psi, batch.psi);
    put(V3<Pack>{term.c, term.c1, term.c2}, batch.term);
  }
}

double FramePairField::energy(ConstRows x) const {
  place(x, work_batches_);
  return evaluateAll(work_batches_);
}

void FramePairField::addForce(ConstRows x, ConstRows v, Rows f) {
  place(x, batches_);
  evaluateAll(batches_);
  const std::size_t lanes = std::size_t(pack_lanes);
  for (std::size_t i = 0; i < batches_.size(); ++i) {
    const Batch& batch = batches_[i];
    const Fixed& fixed = fixed_[i];
    const M3<Pack> axes = axesIn(batch.axes);
    const V3<Pack> psi = vectorIn(batch.psi), k = vectorIn(batch.k), once = cross(psi, k), arm = vectorIn(batch.arm);
    // R_a n and R_a dexp^-T(psi) k: what frame a gets; frame b gets the opposite
    const V3<Pack> force = axes * vectorIn(batch.n);
    const V3<Pack> torque = axes * (k + once * Pack(0.5) + cross(psi, once) * packOf(batch.term[0]));
    if (const std::size_t left = pairs_.size() - i * lanes; left >= lanes) {
      addToRows(force, fixed.rows[0].data(), f.data);
      addToRows(torque + cross(arm, force), fixed.rows[1].data(), f.data);
      addToRows(-force, fixed.rows[2].data(), f.data);
      addToRows(-torque, fixed.rows[3].data(), f.data);
    } else {
      const V3<Pack> each[4] = {force, torque + cross(arm, force), -force, -torque};
      for (std::size_t r = 0; r < 4; ++r)
        forEachRow(each[r], [&](int lane, const auto& row) {
          if (std::size_t(lane) < left) addRow(row, f.data + fixed.rows[r][std::size_t(lane)]);
        });
    }
  }
  if (damped_)
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      if (pairs_[i].damping > 0) damp(i, v, vectorOf(batches_[i / lanes].arm.of(i % lanes)), f);
  outdateTangents();
}

/// With the relative velocity v_b - v_a + [arm] w_a.
void FramePairField::damp(std::size_t pair, ConstRows v, const Vec3& arm, Rows f) {
  const Group& rows = rows_[pair];
  const double damping = pairs_[pair].damping;
  const Vec3 force = -damping * (v[rows[2]] - v[rows[0]] - v[rows[1]].cross(arm));
  const Vec3 torque = -damping * (v[rows[3]] - v[rows[1]]);
  f[rows[2]] += force;
  f[rows[0]] -= force;
  f[rows[3]] += torque;
  f[rows[1]] -= torque + arm.cross(force);
  const Mat3 one = Mat3::Identity();
  DenseTangent<4>& tangent = damping_[pair];
  tangent.setZero();
  const Mat3 of[4] = {-one, crossMatrix(arm), one, Mat3::Zero()};  // relative velocity by the velocities of the rows
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) tangent.block(r, c) = -damping * of[r].transpose() * of[c];
  for (int r : {1, 3})
    for (int c : {1, 3}) tangent.block(r, c) += (r == c ? -damping : damping) * one;
}

/// With d = c_b - c_a and turns th in space: dp = R_a^T (dd - th_a x d), dpsi = dexp^-1(psi) R_a^T (th_b - th_a); force and
/// torque turn with th_a besides.
void FramePairField::computeTangents() const {
  tangent_wrenches_.resize(pairs_.size());
  evaluateAll(batches_, tangent_wrenches_);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Batch& batch = batches_[i / std::size_t(pack_lanes)];
    const std::size_t lane = i % std::size_t(pack_lanes);
    const Vec3 psi_value = vectorOf(batch.psi.of(lane));
    const Triple<Jet> psi{{psi_value.x(), 3}, {psi_value.y(), 4}, {psi_value.z(), 5}};
    const Wrench<Jet>& local = tangent_wrenches_[i];
    const Jet c = chain(dot(psi, psi), batch.term[0][lane], batch.term[1][lane]);
    const Triple<Jet> m = inverseTimes(psi, c, local.k, 1);
    const Jet* rows[6] = {&local.n.x, &local.n.y, &local.n.z, &m.x, &m.y, &m.z};
    Mat3 block[2][2];  // of (f, m) by (p, psi)
    Vec3 force, torque;
    for (int r = 0; r < 6; ++r) {
      (r < 3 ? force : torque)[r % 3] = -rows[r]->value;
      for (int k = 0; k < 6; ++k) block[r / 3][k / 3](r % 3, k % 3) = -rows[r]->slope[k];
    }
    Mat3 axes;
    for (Index entry = 0; entry < 9; ++entry) axes(entry % 3, entry / 3) = batch.axes[std::size_t(entry)][lane];
    force = axes * force, torque = axes * torque;
    const Mat3 inverse = dexpInverse(psi_value) * axes.transpose(), to_p = axes.transpose();
    const Mat3 arm = crossMatrix(vectorOf(batch.arm.of(lane)));
    // of (force, torque) on b by the rows c_a, th_a, c_b, th_b
    Mat3 of[2][4];
    for (int r : {0, 1}) {
      const Mat3 by_p = axes * block[r][0] * to_p, by_turn = axes * block[r][1] * inverse;
      of[r][2] = by_p, of[r][0] = -by_p, of[r][3] = by_turn;
      of[r][1] = by_p * arm - by_turn - crossMatrix(r == 0 ? force : torque);
    }
    DenseTangent<4>& tangent = stiffness_[i];
    for (int k = 0; k < 4; ++k) {
      tangent.block(2, k) = of[0][k];
      tangent.block(0, k) = -of[0][k];
      tangent.block(3, k) = of[1][k];
      tangent.block(1, k) = -of[1][k] - arm * of[0][k];
    }
    // d (arm x force) by the ends of the arm
    tangent.block(1, 2) += crossMatrix(force);
    tangent.block(1, 0) -= crossMatrix(force);
    for (int r = 0; r < 4; ++r)
      for (int k = 0; k <= r; ++k) {
        const Mat3 mean = 0.5 * (tangent.block(r, k) + tangent.block(k, r).transpose());
        tangent.block(r, k) = mean;
        tangent.block(k, r) = mean.transpose();
      }
  }
}

void FramePairField::addSegments(std::vector<Segment>& segments) const {
  for (const Pair& pair : pairs_) segments.push_back({&state(), pair.a, &second(), pair.b, drawnRadius()});
}

}  // namespace stroma
