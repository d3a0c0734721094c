// SPDX-License-Identifier: LGPL-2.1-or-later
// LinearForceField: a force on each of some nodes, given at times and interpolated linearly.
//
//   f_i(t) = forces at t for each of points;  energy = -sum f_i . x_i;  K = 0
//
// Before the first and after the last time the force is constant. On a rigid frame it has six numbers, the force on its centre and the
// torque in fixed axes, which has no energy; on nodes of numbers as many as they have.
//
// Source: the name, points, times and forces are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <LinearForceField points="1 2" times="0 0.5 1" forces="0 0 0  0 -2 0  0 0 1"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/loads/dead_load.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearForceField final : public DeadLoad, public LocalLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("points", points_).alias("indices").help("loaded nodes").required();
    table.add("keyTimes", times_).alias("times").help("times, ascending").unit("s").required();
    table.add("forces", forces_).recompiled().help("force on each of points at each of keyTimes").unit("N").required();
    for (const char* drawing : {"arrowSizeCoef", "showArrowSize"}) table.addVisualOnly(drawing);
  }

  void init() override {
    ForceField::init();
    nodes_ = checkedNodesInOrder(points_, state(), "points");
    findKeys();
    setTime(node().root().root_time);
  }

  ForceTraits traits() const override {
    ForceTraits traits = DeadLoad::traits();
    traits.time_dependent = true;
    if (state().hasFrames()) traits.conservative = false;
    return traits;
  }
  void setTime(double t) override {
    for (std::size_t k = 0; k < keys_.size(); ++k) now_[k] = keys_[k].at(t);
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    forEachRow([&](Index row, std::size_t k) {
      if (state().kindOf(row - state().firstRow()) != RowKind::turn) sum -= now_[k].dot(x[row]);
    });
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    forEachRow([&](Index row, std::size_t k) { f[row] += now_[k]; });
  }
  void addLoadedRows(std::vector<Index>& rows) const override {
    forEachRow([&](Index row, std::size_t) { rows.push_back(row); });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  /// Of each loaded node: the row of the system, and which of the node's rows it is.
  template <class Visit>
  void forEachRow(const Visit& visit) const {
    const Index rows = Index(keys_.size());
    for (const Index first : nodes_)
      for (Index k = 0; k < rows; ++k) visit(state().firstRow() + first + k, std::size_t(k));
  }

  /// For each row of a node, a vector of which a number has x.
  void findKeys() {
    const std::size_t rows = std::size_t(state().rows_per_node), each = state().kindOf(0) == RowKind::value ? 1 : 3, width = each * rows;
    if (forces_.size() % width != 0)
      throw ComponentError(fmt::format("forces has {} numbers", forces_.size()), fmt::format("{} for each time", width));
    keys_.assign(rows, {}), now_.assign(rows, Vec3::Zero());
    for (std::size_t k = 0; k < rows; ++k) {
      std::vector<Vec3> values;
      for (std::size_t at = each * k; at < forces_.size(); at += width)
        values.push_back(each == 1 ? Vec3(forces_[at], 0, 0) : Vec3(forces_[at], forces_[at + 1], forces_[at + 2]));
      keys_[k].assign(times_, std::move(values), "keyTimes", "forces");
      keys_[k].check();
    }
  }

  std::vector<int> points_;
  std::vector<double> times_, forces_;  ///< as written
  std::vector<KeyTimes<Vec3>> keys_;    ///< shape (rows of a node)
  std::vector<Index> nodes_;  ///< the first row of each
  std::vector<Vec3> now_;  ///< [N], shape (rows of a node)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_force_field) {
  factory.add<stroma::LinearForceField>("LinearForceField", "forces on nodes, given at times and linear between them");
}
