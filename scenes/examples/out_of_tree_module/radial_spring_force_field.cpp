// SPDX-License-Identifier: LGPL-2.1-or-later
// RadialSpringForceField: every chosen node hangs on a spring from one common centre.
//
// With d = x_i - c, r = |d|, n = d / r, spring constant k and rest length r0, node i has
//
//   energy      k/2 (r - r0)^2
//   force       f = -k (r - r0) n
//   stiffness   df/dx = -k ( n n^T + (1 - r0/r) (I - n n^T) )
//
// At r = 0 the direction n is not defined: the force is zero there and the stiffness -k I.
//
// Example:
// <Node name="root" gravity="0 0 0" dt="0.001">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="1 0 0  0 2 0"/>
//   <UniformMass vertexMass="1"/>
//   <RadialSpringForceField name="springs" centre="0 0 0" stiffness="39.478417604357434" restLength="0"/>
// </Node>
#include <cmath>

#include "framework/mechanics/force_field.h"
#include "framework/scene/factory.h"

using namespace stroma;

namespace {

class RadialSpringForceField final : public ForceField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("centre", centre_).unit("m").help("where all springs are fixed");
    table.add("stiffness", stiffness_).unit("N/m").min(0).required().help("spring constant of each spring");
    table.add("restLength", rest_length_).unit("m").min(0).help("length of a spring without force");
    table.add("indices", indices_).unit("-").help("nodes that have a spring; not given: all nodes");
  }

  void init() override {
    ForceField::init();
    const Index size = state().size();
    if (!data().find("indices")->isSet()) {
      indices_.clear();
      for (Index i = 0; i < size; ++i) indices_.push_back(int(i));
    }
    for (int index : indices_) {
      if (index < 0 || index >= size)
        throw ComponentError("node " + std::to_string(index) + " does not exist", "0 to " + std::to_string(size - 1));
    }
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.linear = traits.constant_stiffness = rest_length_ == 0;
    return traits;
  }

  void compile() override {
    stiffness_blocks_.assign(indices_.size(), Mat3(-stiffness_ * Mat3::Identity()));
    rows_.clear();
    for (int index : indices_) rows_.push_back(state().firstRow() + Index(index));
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (Index row : rows_) {
      const double stretch = (x[row] - centre_).norm() - rest_length_;
      sum += stiffness_ / 2 * stretch * stretch;
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t s = 0; s < rows_.size(); ++s) {
      const Vec3 d = x[rows_[s]] - centre_;
      const double r = d.norm();
      if (r == 0) {
        stiffness_blocks_[s] = -stiffness_ * Mat3::Identity();
        continue;
      }
      const Vec3 n = d / r;
      const Mat3 along = n * n.transpose();
      f[rows_[s]] -= stiffness_ * (r - rest_length_) * n;
      stiffness_blocks_[s] = -stiffness_ * (along + (1 - rest_length_ / r) * (Mat3::Identity() - along));
    }
  }

  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    for (std::size_t s = 0; s < rows_.size(); ++s) df[rows_[s]] += factor * (stiffness_blocks_[s] * dx[rows_[s]]);
  }

  void addPattern(BlockPattern& pattern) const override {
    for (Index row : rows_) pattern.addBlock(row, row);
  }

  void addStiffness(double factor, BlockMatrix& matrix) const override {
    for (std::size_t s = 0; s < rows_.size(); ++s) matrix.add(rows_[s], rows_[s], factor * stiffness_blocks_[s]);
  }

  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    for (std::size_t s = 0; s < rows_.size(); ++s) {
      double* block = blocks.data() + std::size_t(rows_[s]) * 9;
      for (int i = 0; i < 9; ++i) block[i] += factor * stiffness_blocks_[s](i / 3, i % 3);
    }
  }

 private:
  Vec3 centre_ = Vec3::Zero();
  double stiffness_ = 1, rest_length_ = 0;
  std::vector<int> indices_;
  std::vector<Index> rows_;             ///< shape (springs): row of each spring's node
  std::vector<Mat3> stiffness_blocks_;  ///< [N/m], shape (springs): df/dx at the x of the last addForce()
};

}  // namespace

STROMA_COMPONENT(radial_spring_force_field) {
  factory.add<RadialSpringForceField>("RadialSpringForceField", "springs from nodes to one common centre");
}
