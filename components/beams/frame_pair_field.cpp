// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/frame_pair_field.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

namespace {

Vec3 vectorOf(const Triple<double>& a) { return {a.x, a.y, a.z}; }

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
    put(axes, batch.axes);
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
    const M3<Pack> axes = matrixIn(batch.axes);
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

namespace {

/// A number of each pair with its derivatives.
Triple<PackJet> jetsIn(const LanesOf<3>& values, const LanesOf<18>& slopes) {
  Triple<PackJet> jets;
  PackJet* rows[3] = {&jets.x, &jets.y, &jets.z};
  for (std::size_t r = 0; r < 3; ++r) {
    rows[r]->value = packOf(values[r]);
    for (std::size_t k = 0; k < 6; ++k) rows[r]->slope[k] = packOf(slopes[6 * r + k]);
  }
  return jets;
}
Triple<PackJet> variables(const V3<Pack>& values, int first) {
  return {{values.x, first}, {values.y, first + 1}, {values.z, first + 2}};
}
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
  tangent.block(3, 2) = c, tangent.block(3, 0) = -c, tangent.block(2, 3) = c.transpose(), tangent.block(0, 3) = -c.transpose();
  tangent.block(2, 1) = e, tangent.block(0, 1) = -e, tangent.block(1, 2) = e.transpose(), tangent.block(1, 0) = -e.transpose();
  tangent.block(3, 1) = g, tangent.block(1, 3) = g.transpose();
  tangent.block(3, 3) = h, tangent.block(1, 1) = blockIn(blocks.first, lane);
}

}  // namespace

/// With d = c_b - c_a and turns th in space: dp = R_a^T (dd - th_a x d), dpsi = dexp^-1(psi) R_a^T (th_b - th_a); force f and
/// torque m on b turn with th_a besides. With K_xy = -R_a dx/dy R_a^T for p, and -R_a dx/dpsi dexp^-1(psi) R_a^T for psi, less
/// skew parts, the blocks are S = K_np, C = (K_mp + K_npsi^T)/2, H = K_mpsi, and by th_a
///   (c_b, a) = S [d] - C^T - [f],  (b, a) = C [d] - H - [m]/2,
///   (a, a) = H - C [d] - (C [d])^T - [d] S [d] + (f d^T + d f^T)/2 - (d.f) I
void FramePairField::computeTangents() const {
  slopes_.resize(batches_.size());
  evaluateAll(batches_, slopes_);
  const std::size_t lanes = std::size_t(pack_lanes);
  for (std::size_t i = 0; i < batches_.size(); ++i) {
    const Batch& batch = batches_[i];
    const V3<Pack> psi_value = vectorIn(batch.psi), arm = vectorIn(batch.arm);
    const Triple<PackJet> psi = variables(psi_value, 3), n = jetsIn(batch.n, slopes_[i].n), k = jetsIn(batch.k, slopes_[i].k);
    const Triple<PackJet> m = inverseTimes(psi, chain(dot(psi, psi), packOf(batch.term[0]), packOf(batch.term[1])), k, 1);
    const M3<Pack> axes = matrixIn(batch.axes), to_p = transpose(axes);
    const auto inverse = [&](const V3<Pack>& v) {
      const V3<Pack> once = cross(psi_value, v);
      return v - once * Pack(0.5) + cross(psi_value, once) * packOf(batch.term[0]);
    };
    const M3<Pack> to_psi{inverse(to_p.c0), inverse(to_p.c1), inverse(to_p.c2)};
    const V3<Pack> force = -(axes * V3<Pack>{n.x.value, n.y.value, n.z.value});
    const V3<Pack> torque = -(axes * V3<Pack>{m.x.value, m.y.value, m.z.value});
    const M3<Pack> s = symmetric(axes * fallOf(n, 0) * to_p), h = symmetric(axes * fallOf(m, 3) * to_psi);
    const M3<Pack> c = (axes * fallOf(m, 0) * to_p + transpose(axes * fallOf(n, 3) * to_psi)) * Pack(0.5);
    const M3<Pack> turned = timesCross(c, arm), swung = timesCross(s, arm), one = identity<Pack>();
    const M3<Pack> outer{force * arm.x, force * arm.y, force * arm.z};
    Blocks blocks;
    put(s, blocks.shift), put(h, blocks.turn), put(c, blocks.turn_by_shift);
    put(swung - transpose(c) - timesCross(one, force), blocks.shift_by_first);
    put(turned - h - timesCross(one, torque * Pack(0.5)), blocks.by_first);
    put(h - symmetric(turned) * Pack(2.) - crossTimes(arm, swung) + symmetric(outer) - one * dot(arm, force), blocks.first);
    for (std::size_t lane = 0; lane < std::min(lanes, pairs_.size() - i * lanes); ++lane)
      write(blocks, lane, stiffness_[i * lanes + lane]);
  }
}

void FramePairField::addSegments(std::vector<Segment>& segments) const {
  for (const Pair& pair : pairs_) segments.push_back({&state(), pair.a, &second(), pair.b, drawnRadius()});
}

}  // namespace stroma
