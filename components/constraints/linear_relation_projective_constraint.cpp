// SPDX-License-Identifier: LGPL-2.1-or-later
// LinearRelationProjectiveConstraint: sums of coefficients times displacements are zero, exactly.
//
// For each tuple (n_1 ... n_m) of `indices`, m the number of coefficients:
//   sum_j c_j u_{n_j} + sum_k C_k U_{N_k} = 0            in x, y and z, or
//   sum_j c_j d_j . u_{n_j} + sum_k C_k D_k . U_{N_k} = 0    with directions
// u are displacements from the rest positions of object1; C, D, N and U (coefficients2, directions2, indices2) belong to
// object2 and are part of every relation. Inhomogeneous relations need nothing else: a node of object2 moved by a
// LinearMovementProjectiveConstraint contributes its movement, and a loaded one its force.
//
//   all nodes of a face have one displacement        coefficients="1 -1"  indices="0 1  0 2  0 3"  (AttachProjectiveConstraint
//                                                    with twoWay does that at less cost)
//   the mean displacement of four nodes is zero      coefficients="1 1 1 1"  indices="4 5 6 7"
//   a periodic cell under the strain e = U / length  coefficients="-1 1"  indices="left_i right_i ..."  coefficients2="-1"
//   x of one node is y of another, turned by 90 deg  coefficients="1 -1"  indices="0 1"  directions="1 0 0  0 1 0"
//
//   an angle turns twice as fast as another one    coefficients="2 -1"  indices="0 1", of a state of numbers (gears)
//
// Nodes that are numbers have a relation for each number; of rigid frames the centres are related.
//
// Velocities and increments are projected, P = I - N^T N with N an orthonormal basis of the relations, so the equation of a
// step is P A P dv = P b: the forces of the constraint do no work, and no stiffness is added that would spoil the condition of
// A. Positions satisfy the relations at the end of every step, to round-off. Relations that follow from others, or from fixed
// nodes, are detected and harmless; those that contradict fixed nodes are rejected, and stop a run in which they arise.
//
// Costs: relations that share free nodes form a cluster. A cluster of n nodes takes 3 n numbers per relation in each
// projection and, with an assembled matrix, (3 n)^2 numbers: the mean over a large face is for matrix-free solvers.
//
// Source: elimination of linear multi-point constraints, e.g. Shephard, "Linear multipoint constraints applied via
// transformation as part of a direct stiffness assembly process", Int. J. Numer. Meth. Engng. 20 (1984); here by an orthogonal
// projector instead of a choice of dependent nodes.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0  3 0 0"/>
//   <UniformMass totalMass="0.4"/>
//   <SpringForceField springsIndices1="0 1 2" springsIndices2="1 2 3" lengths="1 1 1" stiffness="200"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <LinearRelationProjectiveConstraint indices="1 2 3" coefficients="1 -2 1"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Nodes of one state with what they count.
struct Terms {
  std::vector<int> indices;
  std::vector<double> coefficients;
  std::vector<Vec3> directions;
};

class LinearRelationProjectiveConstraint final : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.addLink("object1", object1_).help("state of indices; the one of this node by default");
    table.addLink("object2", object2_).help("state of indices2; that of object1 by default");
    table.add("indices", own_.indices).help("nodes: as many for each relation as there are coefficients").required();
    table.add("coefficients", own_.coefficients).unit("-").help("c_j, those of one relation").required();
    table.add("directions", own_.directions)
        .unit("-")
        .help("d_j, one for each coefficient or one for all; not given: the relation holds in x, y and z");
    table.add("indices2", common_.indices).help("nodes of object2 that are part of every relation");
    table.add("coefficients2", common_.coefficients).unit("-").help("C_k, one for each of indices2");
    table.add("directions2", common_.directions).unit("-").help("D_k, one for each of indices2 or one for all");
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ProjectiveConstraint::init();
    second_ = object2_.get() ? object2_.get() : &state();
    checkTypes();
    nodes_ = checkedNodesInOrder(own_.indices, state(), "indices");
    const std::size_t terms = own_.coefficients.size();
    if (terms == 0) throw ComponentError("coefficients is empty", "one number for each term of a relation");
    if (nodes_.size() % terms != 0)
      throw ComponentError(fmt::format("indices has {} nodes and coefficients {} numbers", nodes_.size(), terms),
                           fmt::format("a multiple of {} nodes: as many for each relation", terms));
    if (!common_.indices.empty()) common_nodes_ = checkedNodesInOrder(common_.indices, *second_, "indices2");
    if (common_.coefficients.size() != common_nodes_.size())
      throw ComponentError(fmt::format("coefficients2 has {} numbers for {} nodes of indices2",
                                       common_.coefficients.size(), common_nodes_.size()),
                           "one for each");
    for (std::size_t first = 0; first < nodes_.size(); first += terms)
      checkDistinct("indices", nodes_.data() + first, nodes_.data() + first + terms, state().rows_per_node);
    checkDistinct("indices2", common_nodes_.data(), common_nodes_.data() + common_nodes_.size(),
                  second_->rows_per_node);
    checkDirections();
    checkCoefficients("coefficients", own_.coefficients);
    checkCoefficients("coefficients2", common_.coefficients);
    tellOfStart();
  }

  std::vector<State*> states() const override { return {&state(), second_}; }
  void addProjectors(double, std::vector<NodeProjector>&) const override {}
  void addRelations(LinearRelations& out) const override {
    if (!own_.directions.empty()) return addAlong(out, 0, [](const Vec3& direction) { return direction; });
    if (relatesNumbers())
      for (Index k = 0; k < state().rows_per_node; ++k) addAlong(out, k, [](const Vec3&) { return Vec3(Vec3::UnitX()); });
    else
      for (int axis = 0; axis < 3; ++axis) addAlong(out, 0, [axis](const Vec3&) { return Vec3(Vec3::Unit(axis)); });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  bool relatesNumbers() const { return state().kindOf(0) == RowKind::value; }

  void checkTypes() const {
    const bool others = second_->kindOf(0) == RowKind::value;
    if (relatesNumbers() != others || (others && state().rows_per_node != second_->rows_per_node))
      throw ComponentError(fmt::format("the nodes of {} and {} are of different types", state().path(), second_->path()),
                           "states of one template, or points and frames");
    if (relatesNumbers() && !(own_.directions.empty() && common_.directions.empty()))
      throw ComponentError(fmt::format("the nodes of {} are numbers, which have no directions", state().path()),
                           "no directions and no directions2");
  }

  void checkDirections() {
    if (own_.directions.empty() != common_.directions.empty() && !common_nodes_.empty())
      throw ComponentError("only one of directions and directions2 is given", "both or none");
    if (common_nodes_.empty() && !common_.directions.empty())
      throw ComponentError("directions2 is given without indices2", "nodes in indices2");
    if (own_.directions.empty()) return;
    spread(own_.directions, own_.coefficients.size(), "directions", "coefficients");
    if (!common_nodes_.empty()) spread(common_.directions, common_nodes_.size(), "directions2", "nodes of indices2");
    for (const std::vector<Vec3>* directions : {&own_.directions, &common_.directions})
      for (const Vec3& direction : *directions)
        if (direction.isZero(0)) throw ComponentError("a direction is 0 0 0", "a direction that is not zero");
  }

  /// A node that stands twice in a relation may take itself out of it.
  static void checkDistinct(const char* attribute, const Index* begin, const Index* end, Index rows_per_node) {
    for (const Index* node = begin; node != end; ++node)
      if (std::find(begin, node, *node) != node)
        throw ComponentError(fmt::format("{} has node {} twice in one relation", attribute, *node / rows_per_node),
                             "each node once, with the sum of its coefficients");
  }

  void checkCoefficients(const char* attribute, const std::vector<double>& coefficients) const {
    for (const double coefficient : coefficients)
      if (!(std::abs(coefficient) >= 1e-100 && std::abs(coefficient) <= 1e100))
        throw ComponentError(fmt::format("{} holds {}", attribute, coefficient), "numbers of size 1e-100 to 1e100");
  }

  /// Nodes that start where a relation does not hold are moved.
  void tellOfStart() const {
    LinearRelations relations;
    addRelations(relations);
    const std::size_t terms = own_.coefficients.size();
    double farthest = 0;
    for (Index relation = 0; relation < relations.count(); ++relation) {
      double off = 0, square = 0;
      std::size_t k = 0;
      for (auto term = relations.begin(relation); term != relations.end(relation); ++term, ++k) {
        const State& of = k < terms ? state() : *second_;
        const Vec3& start = of.position[std::size_t(term->row - of.firstRow())];
        off += term->coefficients.dot(start - term->rest);
        square += term->coefficients.squaredNorm();
      }
      farthest = std::max(farthest, std::abs(off) / std::sqrt(square));
    }
    if (farthest > 0)
      inform(fmt::format("nodes start up to {:.3g} m from positions that satisfy the relations: they are moved there", farthest));
  }

  /// All relations of row `of_node` of the nodes, with `along` of a term's direction in its place.
  template <class Along>
  void addAlong(LinearRelations& out, Index of_node, const Along& along) const {
    const auto add = [&](const Terms& terms, std::size_t k, const State& of, Index node) {
      const Vec3 direction = terms.directions.empty() ? Vec3(Vec3::Zero()) : terms.directions[k];
      out.terms.push_back(
          {of.firstRow() + node + of_node, terms.coefficients[k] * along(direction),
           of.rest_position[std::size_t(node + of_node)]});
    };
    const std::size_t terms = own_.coefficients.size();
    for (std::size_t first = 0; first < nodes_.size(); first += terms) {
      for (std::size_t k = 0; k < terms; ++k) add(own_, k, state(), nodes_[first + k]);
      for (std::size_t k = 0; k < common_nodes_.size(); ++k) add(common_, k, *second_, common_nodes_[k]);
      out.ends.push_back(Index(out.terms.size()));
    }
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  Terms own_, common_;
  State* second_ = nullptr;
  std::vector<Index> nodes_, common_nodes_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_relation_projective_constraint) {
  factory.add<stroma::LinearRelationProjectiveConstraint>("LinearRelationProjectiveConstraint",
                                                          "Ties nodes by sums of coefficients times displacements");
}
