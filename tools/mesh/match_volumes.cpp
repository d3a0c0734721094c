// SPDX-License-Identifier: LGPL-2.1-or-later
// With phi_l the distance by which the boundary of region l is pushed outward and A_li the area vector of that boundary
// at node i (a third of its triangles'; the gradient of the region's volume V_l in the position of the node), node i
// moves by
//   u_i = sum_l phi_l A_li / a_i,      a_i = half the sum of |A_li| over the regions at the node
// (on the surface between l and m A_li = -A_mi: it moves by (phi_l - phi_m) along the normal). The volumes change by
//   dV_l = sum_m H_lm phi_m + O(u^2),  H_lm = sum_i A_li . A_mi / a_i
// H is symmetric and positive semidefinite; a few Newton steps on V_l = wanted.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"
#include "framework/mesh/simplex_size.h"
#include "tools/mesh/regions.h"

namespace stroma {

namespace {

constexpr int newton_steps = 6;
constexpr double largest_share = 0.3;  ///< of a node's shortest edge, for all steps together

class Matching {
 public:
  Matching(LabelledMesh& mesh, const std::map<int, double>& wanted, double least_angle)
      : mesh_(mesh), least_angle_(least_angle) {
    for (const auto& [label, volume] : wanted) {
      number_[label] = Index(wanted_.size());
      wanted_.push_back(volume);
    }
    collectTriangles();
    measureCells();
  }

  VolumeMatch run() {
    VolumeMatch best;
    best.error = error();
    for (int step = 0; step < newton_steps && best.error > 1e-6; ++step) {
      const std::vector<Vec3> before = mesh_.position;
      last_ = {};
      move();
      last_.error = error();
      best.at_reach = last_.at_reach, best.held_by_angles = last_.held_by_angles;
      if (last_.error < best.error) {
        best.error = last_.error;
        continue;
      }
      mesh_.position = before;
      break;
    }
    return best;
  }

 private:
  void collectTriangles();
  void measureCells();
  void move();
  void keepAngles(const std::vector<Vec3>& before);
  Eigen::VectorXd missing() const;
  double error() const {
    double worst = 0;
    const Eigen::VectorXd difference = missing();
    for (Index l = 0; l < difference.size(); ++l) worst = std::max(worst, std::abs(difference[l]) / wanted_[l]);
    return worst;
  }
  std::array<Vec3, 4> corners(std::size_t cell) const {
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = mesh_.position[mesh_.tetrahedra[cell][i]];
    return p;
  }
  double angle(std::size_t cell) const {
    const auto p = corners(cell);
    if (!(tetrahedronVolume(p[0], p[1], p[2], p[3]) > 0)) return -1;
    return dihedralAngles(p[0], p[1], p[2], p[3])[0];
  }

  LabelledMesh& mesh_;
  double least_angle_;
  VolumeMatch last_;
  std::map<int, Index> number_;
  std::vector<double> wanted_;
  struct Wall {
    Triangle nodes;
    Index inside, outside;  ///< numbers of regions, -1: none that has a wanted volume
  };
  std::vector<Wall> walls_;
  std::vector<Vec3> start_;
  std::vector<double> reach_;  ///< how far each node may go from its start
  std::vector<double> allowed_angle_;
};

void Matching::collectTriangles() {
  const auto numberOf = [this](int label) {
    const auto found = number_.find(label);
    return found == number_.end() ? Index(-1) : found->second;
  };
  for (const RegionTriangle& t : regionTriangles(mesh_))
    walls_.push_back({t.nodes, numberOf(t.inside), numberOf(t.outside)});
}

void Matching::measureCells() {
  start_ = mesh_.position;
  reach_.assign(mesh_.position.size(), std::numeric_limits<double>::infinity());
  for (std::size_t c = 0; c < mesh_.tetrahedra.size(); ++c) {
    const auto p = corners(c);
    for (const auto& [i, j] : cell_kinds::tetrahedron.edges) {
      const double length = largest_share * (p[i] - p[j]).norm();
      for (const int k : {i, j}) {
        double& reach = reach_[mesh_.tetrahedra[c][k]];
        reach = std::min(reach, length);
      }
    }
    allowed_angle_.push_back(std::min(least_angle_, angle(c)));
  }
}

Eigen::VectorXd Matching::missing() const {
  Eigen::VectorXd out(Index(wanted_.size()));
  for (std::size_t l = 0; l < wanted_.size(); ++l) out[Index(l)] = wanted_[l];
  for (std::size_t c = 0; c < mesh_.tetrahedra.size(); ++c) {
    const auto region = number_.find(mesh_.labels[c]);
    const auto p = corners(c);
    if (region != number_.end()) out[region->second] -= tetrahedronVolume(p[0], p[1], p[2], p[3]);
  }
  return out;
}

void Matching::move() {
  const Index regions = Index(wanted_.size());
  std::vector<std::map<Index, Vec3>> area(mesh_.position.size());  // A_li, and under -1 what has no wanted volume
  for (const Wall& wall : walls_) {
    const Vec3 a = mesh_.position[wall.nodes[0]];
    const Vec3 share = (mesh_.position[wall.nodes[1]] - a).cross(mesh_.position[wall.nodes[2]] - a) / 6;
    for (const Index n : wall.nodes) {
      area[n].try_emplace(wall.inside, Vec3::Zero()).first->second += share;
      area[n].try_emplace(wall.outside, Vec3::Zero()).first->second -= share;
    }
  }
  std::vector<double> size(area.size(), 0);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(regions, regions);
  for (std::size_t n = 0; n < area.size(); ++n) {
    for (const auto& [l, vector] : area[n]) size[n] += vector.norm() / 2;
    if (!(size[n] > 0)) continue;
    for (const auto& [l, a] : area[n])
      for (const auto& [m, b] : area[n])
        if (l >= 0 && m >= 0) h(l, m) += a.dot(b) / size[n];
  }
  const Eigen::VectorXd phi = h.completeOrthogonalDecomposition().solve(missing());
  const std::vector<Vec3> before = mesh_.position;
  for (std::size_t n = 0; n < area.size(); ++n) {
    if (!(size[n] > 0)) continue;
    Vec3 way = mesh_.position[n] - start_[n];
    for (const auto& [l, a] : area[n])
      if (l >= 0) way += phi[l] * a / size[n];
    if (const double length = way.norm(); length > reach_[n]) {
      way *= reach_[n] / length;
      ++last_.at_reach;
    }
    mesh_.position[n] = start_[n] + way;
  }
  keepAngles(before);
}

/// Takes nodes of cells that have become too flat half of the way back, at last all of it, until no cell is.
void Matching::keepAngles(const std::vector<Vec3>& before) {
  constexpr int halvings = 4;
  std::vector<char> held(mesh_.position.size(), 0);
  for (int round = 0;; ++round) {
    std::vector<char> back(mesh_.position.size(), 0);
    bool any = false;
    for (std::size_t c = 0; c < mesh_.tetrahedra.size(); ++c) {
      if (angle(c) >= allowed_angle_[c] - 1e-9) continue;
      for (const Index n : mesh_.tetrahedra[c]) {
        const std::size_t i = std::size_t(n);
        if (!(mesh_.position[i] == before[i])) {
          back[i] = 1;
          any = true;
        }
      }
    }
    if (!any) break;
    for (std::size_t i = 0; i < back.size(); ++i) held[i] |= back[i];
    for (std::size_t i = 0; i < back.size(); ++i)
      if (back[i]) mesh_.position[i] = round < halvings ? Vec3((mesh_.position[i] + before[i]) / 2) : before[i];
  }
  last_.held_by_angles = Index(std::count(held.begin(), held.end(), 1));
}

}  // namespace

VolumeMatch matchVolumes(LabelledMesh& mesh, const std::map<int, double>& wanted, double least_angle) {
  return Matching(mesh, wanted, least_angle).run();
}

}  // namespace stroma
