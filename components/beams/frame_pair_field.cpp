// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/frame_pair_field.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

void FramePairField::setPairs(std::vector<Pair> pairs, State* second) {
  second_ = second == &state() ? nullptr : second;
  for (const State* each : {&state(), &this->second()})
    if (!each->hasFrames())
      throw ComponentError(fmt::format("{} has no frames", each->path()), "a state of template Rigid3");
  pairs_ = std::move(pairs);
  are_laid_out_ = false;
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
  const std::array<Index, 2> first{state().firstRow(), second().firstRow()};
  if (are_laid_out_ && first == first_rows_) return;
  first_rows_ = first, are_laid_out_ = true;
  std::vector<Group> rows;
  for (const Pair& pair : pairs_) {
    const Index a = state().firstRow() + pair.a, b = second().firstRow() + pair.b;
    rows.push_back({a, a + 1, b, b + 1});
  }
  setGroups(std::move(rows), damped_);
  const std::size_t lanes = std::size_t(pack_lanes);
  fixed_.resize(batchesOf(pairs_.size()));
  for (std::size_t i = 0; i < fixed_.size() * lanes; ++i) {
    Fixed& fixed = fixed_[i / lanes];
    const std::size_t lane = i % lanes, last = std::min(i, pairs_.size() - 1);
    for (std::size_t k = 0; k < 4; ++k) fixed.rows[k][lane] = rows_[last][k] * row_doubles;
  }
  placeAxes();
  kept_.assign(fixed_.size(), {});
}

void FramePairField::placeAxes() {
  const std::size_t lanes = std::size_t(pack_lanes);
  for (std::size_t i = 0; i < fixed_.size() * lanes; ++i) {
    const Pair& pair = pairs_[std::min(i, pairs_.size() - 1)];
    for (std::size_t k = 0; k < 4; ++k) {
      fixed_[i / lanes].axes_a[k][i % lanes] = pair.axes_a.coeffs()[Index(k)];
      fixed_[i / lanes].axes_b[k][i % lanes] = pair.axes_b.coeffs()[Index(k)];
    }
  }
}

FramePairField::Placed FramePairField::keptPlace(std::size_t batch) const {
  const Kept& kept = kept_[batch];
  return placed({vectorIn(kept.axes), packOf(kept.axes[3])}, vectorIn(kept.arm), vectorIn(kept.psi));
}

void FramePairField::addForce(ConstRows x, ConstRows v, Rows f) {
  pull(x, f);
  if (damped_)
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      if (pairs_[i].damping > 0) damp(i, x, v, f);
  outdateTangents();
}

/// With the relative velocity v_b - v_a + [arm] w_a.
void FramePairField::damp(std::size_t pair, ConstRows x, ConstRows v, Rows f) {
  const Group& rows = rows_[pair];
  const Vec3 arm = x[rows[2]] - x[rows[0]];
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

namespace {

/// Minus the derivatives by three of the six.
M3<Pack> fallOf(const Triple<PackJet>& of, std::size_t first) {
  const auto column = [&](std::size_t k) { return -V3<Pack>{of.x.slope[k], of.y.slope[k], of.z.slope[k]}; };
  return {column(first), column(first + 1), column(first + 2)};
}
/// m [a], with [a] v = a x v.
M3<Pack> timesCross(const M3<Pack>& m, const V3<Pack>& a) {
  return {m.c1 * a.z - m.c2 * a.y, m.c2 * a.x - m.c0 * a.z, m.c0 * a.y - m.c1 * a.x};
}
M3<Pack> crossTimes(const V3<Pack>& a, const M3<Pack>& m) { return {cross(a, m.c0), cross(a, m.c1), cross(a, m.c2)}; }
M3<Pack> symmetric(const M3<Pack>& m) { return (m + transpose(m)) * Pack(0.5); }

/// The blocks of a pair's tangent: of c_a and a the first end's rows, of c_b and b the second one's. The others are these,
/// transposed or with the other sign.
struct Blocks {
  LanesOf<9> shift, turn;              ///< (c_b, c_b), (b, b)
  LanesOf<9> turn_by_shift;            ///< (b, c_b)
  LanesOf<9> shift_by_first, by_first; ///< (c_b, a), (b, a)
  LanesOf<9> first;                    ///< (a, a)
};

Mat3 blockIn(const LanesOf<9>& lanes, std::size_t lane) {
  Mat3 block;
  for (std::size_t entry = 0; entry < 9; ++entry) block.data()[entry] = lanes[entry][lane];
  return block;
}

void write(const Blocks& blocks, std::size_t lane, DenseTangent<4>& tangent) {
  const Mat3 s = blockIn(blocks.shift, lane), h = blockIn(blocks.turn, lane), c = blockIn(blocks.turn_by_shift, lane);
  const Mat3 e = blockIn(blocks.shift_by_first, lane), g = blockIn(blocks.by_first, lane);
  tangent.block(0, 0) = tangent.block(2, 2) = s, tangent.block(0, 2) = tangent.block(2, 0) = -s;
  tangent.block(3, 2) = c;
  tangent.block(3, 0) = -c;
  tangent.block(2, 3) = c.transpose();
  tangent.block(0, 3) = -c.transpose();
  tangent.block(2, 1) = e;
  tangent.block(0, 1) = -e;
  tangent.block(1, 2) = e.transpose();
  tangent.block(1, 0) = -e.transpose();
  tangent.block(3, 1) = g, tangent.block(1, 3) = g.transpose();
  tangent.block(3, 3) = h, tangent.block(1, 1) = blockIn(blocks.first, lane);
}

}  // namespace

/// With d = c_b - c_a and turns th in space: dp = R_a^T (dd - th_a x d), dpsi = dexp^-1(psi) R_a^T (th_b - th_a); force f and
/// torque m on b turn with th_a besides. With K_xy = -R_a dx/dy R_a^T for p, and -R_a dx/dpsi dexp^-1(psi) R_a^T for psi, less
/// skew parts, the blocks are S = K_np, C = (K_mp + K_npsi^T)/2, H = K_mpsi, and by th_a
///   (c_b, a) = S [d] - C^T - [f],  (b, a) = C [d] - H - [m]/2,
///   (a, a) = H - C [d] - (C [d])^T - [d] S [d] + (f d^T + d f^T)/2 - (d.f) I
void FramePairField::writeTangents(std::size_t batch, const Placed& at, const Wrench<PackJet>& wrench) const {
  const auto& [n, k, energy] = wrench;
  const Triple<PackJet> psi = variables(at.psi, 3);
  const Triple<PackJet> m = inverseTimes(psi, chain(dot(psi, psi), at.term.c, at.term.c1), k, 1);
  const M3<Pack>& axes = at.axes;
  const M3<Pack> to_p = transpose(axes);
  const auto inverse = [&](const V3<Pack>& v) {
    const V3<Pack> once = cross(at.psi, v);
    return v - once * Pack(0.5) + cross(at.psi, once) * at.term.c;
  };
  const M3<Pack> to_psi{inverse(to_p.c0), inverse(to_p.c1), inverse(to_p.c2)};
  const V3<Pack> force = -(axes * V3<Pack>{n.x.value, n.y.value, n.z.value});
  const V3<Pack> torque = -(axes * V3<Pack>{m.x.value, m.y.value, m.z.value});
  const M3<Pack> s = symmetric(axes * fallOf(n, 0) * to_p), h = symmetric(axes * fallOf(m, 3) * to_psi);
  const M3<Pack> c = (axes * fallOf(m, 0) * to_p + transpose(axes * fallOf(n, 3) * to_psi)) * Pack(0.5);
  const M3<Pack> turned = timesCross(c, at.arm), swung = timesCross(s, at.arm), one = identity<Pack>();
  const M3<Pack> outer{force * at.arm.x, force * at.arm.y, force * at.arm.z};
  Blocks blocks;
  put(s, blocks.shift), put(h, blocks.turn), put(c, blocks.turn_by_shift);
  put(swung - transpose(c) - timesCross(one, force), blocks.shift_by_first);
  put(turned - h - timesCross(one, torque * Pack(0.5)), blocks.by_first);
  put(h - symmetric(turned) * Pack(2.) - crossTimes(at.arm, swung) + symmetric(outer) - one * dot(at.arm, force), blocks.first);
  for (std::size_t lane = 0; lane < pairsIn(batch); ++lane) write(blocks, lane, stiffness_[batch * std::size_t(pack_lanes) + lane]);
}

void FramePairField::addSegments(std::vector<Segment>& segments) const {
  for (const Pair& pair : pairs_) segments.push_back({&state(), pair.a, &second(), pair.b, drawnRadius()});
}

}  // namespace stroma
