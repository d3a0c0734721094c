// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/cell_turns.h"

#include <Eigen/SVD>
#include <algorithm>

#include "framework/mechanics/signs.h"

namespace stroma {

namespace {

/// The rotation next to F, F's stretch in its axes, and the inverse of tr(S) I - S. In a cell turned inside out sums of its
/// stretches can vanish: they are kept from zero.
void decompose(const Mat3& f, Mat3& rotation, Mat3& stretch, Mat3& inverse) {
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 &u = svd.matrixU(), &v = svd.matrixV();
  Vec3 sign(1, 1, u.determinant() * v.determinant() < 0 ? -1 : 1);
  rotation = u * sign.asDiagonal() * v.transpose();
  const Vec3 s = svd.singularValues().cwiseProduct(sign);
  stretch = v * s.asDiagonal() * v.transpose();
  const double least = std::max(1e-6 * s[0], 1e-30);
  Vec3 sums(s[1] + s[2], s[0] + s[2], s[0] + s[1]);
  sums = sums.cwiseMax(least);
  inverse = v * sums.cwiseInverse().asDiagonal() * v.transpose();
}

/// tr(S') I - S' where S' is the change of S.
Mat3 changeOfG(const Mat3& s) { return s.trace() * Mat3::Identity() - s; }

}  // namespace

void CellTurns::add(Index row, const std::vector<Index>& nodes, const std::vector<Vec3>& slopes, const Quaternion& start) {
  Turn turn;
  turn.row = row;
  turn.nodes = nodes;
  turn.slopes = slopes;
  turn.start = turn.before = start;
  turns_.push_back(std::move(turn));
}

void CellTurns::apply(Rows x, Index parent, Index child) const {
  for (Turn& turn : turns_) {
    Mat3 f = Mat3::Zero();
    for (std::size_t a = 0; a < turn.nodes.size(); ++a) f += Vec3(x[parent + turn.nodes[a]]) * turn.slopes[a].transpose();
    decompose(f, turn.rotation, turn.stretch, turn.inverse);
    putOrientation(turn.before, x, child + turn.row);
    putNearest(Quaternion(turn.rotation) * turn.start, x, child + turn.row);
  }
}

void CellTurns::noteSigns(ConstRows x, Index child) const {
  for (Turn& turn : turns_) turn.before = orientationIn(x, child + turn.row);
}

void CellTurns::applyJ(Rows v, Index parent, Index child) const {
  for (const Turn& turn : turns_) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t a = 0; a < turn.nodes.size(); ++a)
      sum += turn.slopes[a].cross(turn.rotation.transpose() * Vec3(v[parent + turn.nodes[a]]));
    v[child + turn.row] = turn.rotation * (turn.inverse * sum);
  }
}

void CellTurns::applyJT(Rows f, Index parent, Index child) const {
  for (const Turn& turn : turns_) {
    const Vec3 p = turn.inverse * (turn.rotation.transpose() * Vec3(f[child + turn.row]));
    for (std::size_t a = 0; a < turn.nodes.size(); ++a) f[parent + turn.nodes[a]] += turn.rotation * p.cross(turn.slopes[a]);
  }
}

void CellTurns::addJacobian(std::vector<JacobianBlock>& out, Index parent, Index child) const {
  for (const Turn& turn : turns_)
    for (std::size_t a = 0; a < turn.nodes.size(); ++a)
      out.push_back({child + turn.row, parent + turn.nodes[a],
                     turn.rotation * turn.inverse * crossMatrix(turn.slopes[a]) * turn.rotation.transpose()});
}

void CellTurns::addCurvature(ConstRows v, Rows a, Index parent, Index child) const {
  for (const Turn& turn : turns_) {
    const std::size_t count = turn.nodes.size();
    std::array<Vec3, most_cell_nodes> u;
    Vec3 sum = Vec3::Zero(), bend = Vec3::Zero();
    Mat3 gradient = Mat3::Zero();
    for (std::size_t n = 0; n < count; ++n) {
      u[n] = turn.rotation.transpose() * Vec3(v[parent + turn.nodes[n]]);
      sum += turn.slopes[n].cross(u[n]);
      gradient += u[n] * turn.slopes[n].transpose();
    }
    const Vec3 w = turn.inverse * sum;
    for (std::size_t n = 0; n < count; ++n) bend += turn.slopes[n].cross(u[n].cross(w));
    const Mat3 change = changeOfG(gradient - crossMatrix(w) * turn.stretch);
    a[child + turn.row] += turn.rotation * (turn.inverse * (bend - change * w));
  }
}

void CellTurns::geometricColumn(const Turn& turn, std::size_t b, const Vec3& torque, Column& column) {
  if (torque.isZero(0)) return column.fill(Mat3::Zero());
  const Vec3 t = turn.rotation.transpose() * torque, p = turn.inverse * t;
  for (int c = 0; c < 3; ++c) {
    const Vec3 u = turn.rotation.transpose().col(c), w = turn.inverse * turn.slopes[b].cross(u);
    const Mat3 change = changeOfG(u * turn.slopes[b].transpose() - crossMatrix(w) * turn.stretch);
    const Vec3 dp = turn.inverse * (-0.5 * w.cross(t) - change * p);
    for (std::size_t a = 0; a < turn.nodes.size(); ++a)
      column[a].col(c) = turn.rotation * (w.cross(p.cross(turn.slopes[a])) + dp.cross(turn.slopes[a]));
  }
}

}  // namespace stroma
