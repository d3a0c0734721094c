// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/frame_pair_field.h"

#include <fmt/format.h>

namespace stroma {

namespace {

Triple<double> tripleOf(const Vec3& a) { return {a.x(), a.y(), a.z()}; }
Vec3 vectorOf(const Triple<double>& a) { return {a.x, a.y, a.z}; }

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
  for (std::vector<Motion>* motions : {&motions_, &work_motions_}) motions->resize(pairs_.size());
  for (std::vector<Wrench<double>>* wrenches : {&wrenches_, &work_wrenches_}) wrenches->resize(pairs_.size());
}

void FramePairField::place(ConstRows x, std::vector<Motion>& motions) const {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Group& rows = rows_[i];
    const Quaternion a = orientationIn(x, rows[1]) * pairs_[i].axes_a;
    const Quaternion b = orientationIn(x, rows[3]) * pairs_[i].axes_b;
    Motion& motion = motions[i];
    motion.axes = a.toRotationMatrix();
    motion.arm = x[rows[2]] - x[rows[0]];
    motion.p = tripleOf(motion.axes.transpose() * motion.arm);
    const Vec3 psi = rotationVector(a.conjugate() * b);
    motion.psi = tripleOf(psi);
    motion.term = InverseTerm(psi.squaredNorm());
  }
}

double FramePairField::energy(ConstRows x) const {
  place(x, work_motions_);
  evaluateAll(work_motions_, work_wrenches_);
  double sum = 0;
  for (const Wrench<double>& wrench : work_wrenches_) sum += wrench.energy;
  return sum;
}

void FramePairField::addForce(ConstRows x, ConstRows v, Rows f) {
  place(x, motions_);
  evaluateAll(motions_, wrenches_);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Group& rows = rows_[i];
    const Motion& motion = motions_[i];
    const Wrench<double>& local = wrenches_[i];
    Vec3 force = -motion.axes * vectorOf(local.n),
         torque = -motion.axes * vectorOf(inverseTimes(motion.psi, motion.term.c, local.k, 1));
    if (const double damping = pairs_[i].damping; damping > 0) {
      force -= damping * (v[rows[2]] - v[rows[0]] - v[rows[1]].cross(motion.arm));
      torque -= damping * (v[rows[3]] - v[rows[1]]);
      // relative velocity = v_b - v_a + [arm] w_a
      const Mat3 arm = crossMatrix(motion.arm), one = Mat3::Identity();
      DenseTangent<4>& tangent = damping_[i];
      tangent.setZero();
      const Mat3 of[4] = {-one, arm, one, Mat3::Zero()};  // relative velocity by the velocities of the rows
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) tangent.block(r, c) = -damping * of[r].transpose() * of[c];
      for (int r : {1, 3})
        for (int c : {1, 3}) tangent.block(r, c) += (r == c ? -damping : damping) * one;
    }
    f[rows[2]] += force;
    f[rows[0]] -= force;
    f[rows[3]] += torque;
    f[rows[1]] -= torque + motion.arm.cross(force);
  }
  outdateTangents();
}

/// With d = c_b - c_a and turns th in space: dp = R_a^T (dd - th_a x d), dpsi = dexp^-1(psi) R_a^T (th_b - th_a); force and
/// torque turn with th_a besides.
void FramePairField::computeTangents() const {
  tangent_wrenches_.resize(pairs_.size());
  evaluateAll(motions_, tangent_wrenches_);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Motion& motion = motions_[i];
    const Triple<Jet> psi{{motion.psi.x, 3}, {motion.psi.y, 4}, {motion.psi.z, 5}};
    const Wrench<Jet>& local = tangent_wrenches_[i];
    const Jet c = chain(dot(psi, psi), motion.term.c, motion.term.c1);
    const Triple<Jet> m = inverseTimes(psi, c, local.k, 1);
    const Jet* rows[6] = {&local.n.x, &local.n.y, &local.n.z, &m.x, &m.y, &m.z};
    Mat3 block[2][2];  // of (f, m) by (p, psi)
    Vec3 force, torque;
    for (int r = 0; r < 6; ++r) {
      (r < 3 ? force : torque)[r % 3] = -rows[r]->value;
      for (int k = 0; k < 6; ++k) block[r / 3][k / 3](r % 3, k % 3) = -rows[r]->slope[k];
    }
    const Mat3& axes = motion.axes;
    force = axes * force, torque = axes * torque;
    const Mat3 inverse = dexpInverse(vectorOf(motion.psi)) * axes.transpose(), to_p = axes.transpose();
    const Mat3 arm = crossMatrix(motion.arm);
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
