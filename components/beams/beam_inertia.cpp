// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/beam_inertia.h"

namespace stroma {

void BeamInertia::set(const std::vector<ChainBeam>& beams, const std::vector<double>& densities, Index first_row) {
  rows_.clear();
  masses_.clear();
  local_.clear();
  axes_a_.clear();
  axes_b_.clear();
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Index a = first_row + 2 * beams[i].a, b = first_row + 2 * beams[i].b;
    rows_.push_back({a, a + 1, b, b + 1});
    masses_.push_back(beams[i].is_there ? densities[i] * beams[i].section.area * beams[i].length : 0);
    local_.push_back(beams[i].is_there ? localMass(beams[i], densities[i]) : Matrix12(Matrix12::Zero()));
    axes_a_.push_back(beams[i].axes_a), axes_b_.push_back(beams[i].axes_b);
  }
  middles_.resize(beams.size(), Quaternion::Identity());
  bends_.resize(beams.size(), Vec3::Zero());
  blocks_.resize(beams.size());
  outdated_ = true;
}

BeamInertia::Matrix12 BeamInertia::localMass(const ChainBeam& beam, double density) {
  const double l = beam.length, area = beam.section.area;
  Matrix12 m = Matrix12::Zero();
  const auto put = [&m](int i, int j, double value) { m(i, j) = m(j, i) = value; };
  for (const auto& [row, share] : {std::pair(0, 1.), std::pair(3, beam.section.polar() / area)}) {
    put(row, row, share / 3), put(row + 6, row + 6, share / 3), put(row, row + 6, share / 6);
  }
  // bending in the planes x y and x z: displacement, turn, its sign
  struct Plane {
    int shift, turn;
    double sign, moment;
  };
  for (const auto& [shift, turn, sign, moment] : {Plane{1, 5, 1, beam.section.about_z}, Plane{2, 4, -1, beam.section.about_y}}) {
    const double g = moment / area;
    for (const int end : {0, 6}) {
      const double side = end == 0 ? sign : -sign;
      put(shift + end, shift + end, 13. / 35 + 6 * g / (5 * l * l)), put(turn + end, turn + end, l * l / 105 + 2 * g / 15);
      put(shift + end, turn + end, side * (11 * l / 210 + g / (10 * l)));
    }
    put(shift, shift + 6, 9. / 70 - 6 * g / (5 * l * l)), put(turn, turn + 6, -l * l / 140 - g / 30);
    put(shift, turn + 6, sign * (-13 * l / 420 + g / (10 * l))), put(turn, shift + 6, sign * (13 * l / 420 - g / (10 * l)));
  }
  return density * area * l * m;
}

void BeamInertia::place(ConstRows x) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Quaternion a = orientationIn(x, rows_[i][1]) * axes_a_[i], b = orientationIn(x, rows_[i][3]) * axes_b_[i];
    Quaternion bend = a.conjugate() * b;
    if (bend.w() < 0) bend.coeffs() = -bend.coeffs();
    middles_[i] = a * turnedBy(0.5 * rotationVector(bend));
    bends_[i] = a * Vec3(bend.vec() / (1 + bend.w()));
  }
  outdated_ = true;
}

const std::vector<DenseTangent<4>>& BeamInertia::blocks() const {
  if (!outdated_) return blocks_;
  outdated_ = false;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Mat3 turn = middles_[i].toRotationMatrix();
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) blocks_[i].block(r, c) = turn * local_[i].block<3, 3>(3 * r, 3 * c) * turn.transpose();
  }
  return blocks_;
}

// Hamel's equations of 1/2 v^T M v, where w_r is the turning that a row stands for. R = a exp(log(a^-1 b)/2) turns by
// w = (w_a + w_b)/2 - g/2 x (w_b - w_a): with J the left Jacobian of exp it is w_a + a J(u/2)/2 J(u)^-1 a^T (w_b - w_a), u = log(a^-1 b),
// which across the axis is 1/(1 + e^(i|u|/2)) = (1 - i tan(|u|/4))/2.
void BeamInertia::addTurning(ConstRows v, Rows f) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const std::array<Index, 4>& rows = rows_[i];
    std::array<Vec3, 4> rate, turned, p, change;
    p.fill(Vec3::Zero()), change.fill(Vec3::Zero());
    for (std::size_t r = 0; r < 4; ++r) rate[r] = v[rows[r]];
    if (masses_[i] == 0 || (rate[1].isZero(0) && rate[3].isZero(0))) continue;
    const Vec3 &g = bends_[i], w = 0.5 * (rate[1] + rate[3] - g.cross(rate[3] - rate[1]));
    for (std::size_t r = 0; r < 4; ++r) turned[r] = w.cross(rate[r]);
    const DenseTangent<4>& m = blocks()[i];
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        const Mat3& block = m.blocks[std::size_t(4 * r + c)];
        p[std::size_t(r)] += block * rate[std::size_t(c)], change[std::size_t(r)] -= block * turned[std::size_t(c)];
      }
    Vec3 couple = Vec3::Zero();
    for (std::size_t r = 0; r < 4; ++r) couple += 0.5 * p[r].cross(rate[r]);
    for (std::size_t r = 0; r < 4; ++r) f[rows[r]] -= w.cross(p[r]) + change[r];
    f[rows[1]] += couple - g.cross(couple) - p[1].cross(rate[1]);
    f[rows[3]] += couple + g.cross(couple) - p[3].cross(rate[3]);
  }
}

}  // namespace stroma
