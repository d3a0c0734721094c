// SPDX-License-Identifier: LGPL-2.1-or-later
// Flat cells of N nodes with a stiffness about their places at rest X:
//   f_i = sum_j K_ij (x_j - X_j),  energy -1/2 sum_ij (x_i - X_i) . K_ij (x_j - X_j);
// K_ij of each cell is its entry of stiffness_, which a component writes.
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"

namespace stroma {

template <int N>
class FlatCells : public NodeGroupField<N> {
 public:
  using Cell = std::array<Index, std::size_t(N)>;

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t e = 0; e < cells_.size(); ++e)
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) sum -= moved(e, i, x).dot(this->stiffness_[e].block(i, j) * moved(e, j, x)) / 2;
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t e = 0; e < cells_.size(); ++e) addForceOf(e, x, f);
  }

 protected:
  /// `body`: what the thickness is of.
  void declareSheet(DataTable& table, const std::string& body) {
    ForceField::declare(table);
    topology_.declare(table, "surface");
    table.add("youngModulus", young_).recompiled().help("Young's modulus").unit("Pa").min(0).physical();
    table.add("poissonRatio", poisson_).recompiled().help("Poisson's ratio").unit("-").min(-1, false).max(0.5).physical();
    table.add("thickness", thickness_).recompiled().help("thickness of the " + body).unit("m").min(0, false).physical();
  }
  /// One group of rows for each cell.
  void setCellGroups() {
    std::vector<Cell> rows = cells_;
    for (Cell& cell : rows)
      for (Index& row : cell) row += this->state().firstRow();
    this->setGroups(std::move(rows), false);
  }
  void addForceOf(std::size_t e, ConstRows x, Rows f) const {
    for (int j = 0; j < N; ++j) {
      const Vec3 u = moved(e, j, x);
      for (int i = 0; i < N; ++i) f[this->rows_[e][std::size_t(i)]] += this->stiffness_[e].block(i, j) * u;
    }
  }
  const Vec3& restOf(std::size_t e, int corner) const {
    return this->state().rest_position[std::size_t(cells_[e][std::size_t(corner % N)])];
  }
  Vec3 moved(std::size_t e, int corner, ConstRows x) const {
    return Vec3(x[this->rows_[e][std::size_t(corner)]]) - restOf(e, corner);
  }

  TopologyLink topology_;
  double young_ = 1000;
  double poisson_ = 0.3;
  double thickness_ = 1;
  std::vector<Cell> cells_;
};

}  // namespace stroma
