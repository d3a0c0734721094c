// SPDX-License-Identifier: LGPL-2.1-or-later
// AttachProjectiveConstraint: pairs of nodes, of two bodies or of one, that are one node from then on.
//
// Both ends of a pair have one velocity, and their masses and forces add up, exactly: with P the mean over the pair, the
// step solves P (m M + k K + c C) P. Two bodies attached at matching nodes are the merged body. Ends that lie apart at the
// start are brought together at their mass-weighted mean, and so are their velocities; in directions in which another constraint
// holds one end, where that end is.
//
// twoWay="false" (the default of SOFA): the nodes of indices2 follow those of indices1, which feel nothing. Positions and
// velocities coincide at the end of every step; inside a step the follower moves with the velocity that the other had at
// its start. The weight of a body that hangs or rests on its followers alone is then carried by nobody: a run says how
// large the force is that the attachment took.
//
// There meet="halfway" does as SOFA does with points: in a step the follower goes on with its velocity; then both have the mean of
// their velocities, and the follower the mean of both places. What is followed feels that: half of its acceleration is lost. With
// twoWay it takes points that start apart to their mean, whatever their masses.
//
// Rigid frames that are attached are one body: the sum of their masses and inertias, with one orientation, their mean at the
// start. A frame and a point share the frame's centre.
//
// Where one body is meshed finer, pairs of nodes join its surface at single nodes and leave the rest of it free: it is then too
// soft, and a warning says so. Stiff springs between all nodes of the finer surface and points that a BarycentricMapping places in
// the other body hold it whole.
//
// Node indices1[i] of object1 is joined to node indices2[i] of object2; without the objects both are of the state of
// this node. Bodies that have an integrator each move in one system, by the first of them, and a warning says where the
// integrators differ. A node may be attached to several others.
//
// Source: the attributes are SOFA's; there a two-way pair shares positions but not its inertia.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <Node name="a">
//     <MechanicalObject name="dofs" position="0 0 0  1 0 0"/>
//     <UniformMass totalMass="0.2"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="200"/>
//     <FixedProjectiveConstraint indices="0"/>
//   </Node>
//   <Node name="b">
//     <MechanicalObject name="dofs" position="1 0 0  2 0 0"/>
//     <UniformMass totalMass="0.4"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="200"/>
//   </Node>
//   <AttachProjectiveConstraint object1="@a/dofs" object2="@b/dofs" indices1="1" indices2="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/mechanics/right_side.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// What some nodes of a body are of the faces of its volume cells.
struct FacesOf {
  bool cells = false;  ///< it has such cells
  bool whole = false;  ///< a face has all its corners among the nodes

  FacesOf(const State& state, const std::vector<Index>& rows) {
    if (state.rows_per_node != 1) return;
    std::vector<char> among(state.rest_position.size(), 0);
    for (const Index row : rows) among[std::size_t(row)] = 1;
    for (const Topology* topology : topologiesOf(state))
      if (std::size_t(topology->mesh().nodes()) <= among.size())
        forEachCellList([&](const CellKind& kind, const auto& list) { look(kind, list, among); }, topology->mesh());
  }

 private:
  template <class Cell>
  void look(const CellKind& kind, const std::vector<Cell>& list, const std::vector<char>& among) {
    cells = cells || (kind.dimension == 3 && !list.empty());
    for (std::size_t c = 0; c < list.size() && !whole; ++c)
      whole = std::any_of(kind.faces.begin(), kind.faces.end(), [&](const LocalFace& face) {
        return std::all_of(face.nodes.begin(), face.nodes.end(),
                           [&](int node) { return among[std::size_t(list[c][std::size_t(node)])] != 0; });
      });
  }
};

class AttachProjectiveConstraint final : public ProjectiveConstraint, public StartVelocity, public ProjectsRightSide {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.addLink("object1", object1_).help("state of indices1; the one of this node when not given");
    table.addLink("object2", object2_).help("state of indices2; that of object1 when not given");
    table.add("indices1", indices1_).help("nodes of object1, one for each pair").required();
    table.add("indices2", indices2_).help("nodes of object2, one for each pair").required();
    table.add("twoWay", two_way_)
        .help(
            "both ends share mass and forces; false, as in SOFA without it: the second follows and the first feels "
            "nothing");
    table.addChoice("meet", meet_, {"leader", "halfway"})
        .help("where points go that follow without being felt: where those go that they follow, or halfway there, as in SOFA");
    table.add("inMatrix", in_matrix_)
        .help("with twoWay, of points, false: both ends are free in the matrix of an implicit step of one linear solve, whose right side "
              "has their mean, and meet after it: SOFA's way with assembled matrices");
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ProjectiveConstraint::init();
    second_ = object2_.get() ? object2_.get() : &state();
    std::tie(leaders_, followers_) = checkedPairs({"indices1", indices1_, state()}, {"indices2", indices2_, *second_});
    rows_ = sharedRows();
    freely_.reserve(leaders_.size());
    double farthest = 0;
    for (std::size_t i = 0; i < leaders_.size(); ++i) {
      if (second_ == &state() && leaders_[i] == followers_[i])
        throw ComponentError(fmt::format("node {} is attached to itself", leaders_[i] / state().rows_per_node),
                             "two different nodes");
      farthest = std::max(farthest, (state().position[leaders_[i]] - second_->position[followers_[i]]).norm());
    }
    if (!data().find("twoWay")->isSet())
      inform("twoWay is not given: both ends feel each other; in SOFA the second follows and the first feels nothing");
    else if (!two_way_)
      inform(
          fmt::format("{} feels nothing of what follows it: the force that holds the nodes of {} is received by nobody",
                      state().path(), second_->path()));
    if (farthest > 0)
      inform(fmt::format("attached nodes lie up to {:.3g} m apart: they are brought together", farthest));
    if (!in_matrix_ && (!two_way_ || !ofPoints()))
      throw ComponentError("inMatrix=\"false\" is of points that are attached both ways",
                           "twoWay=\"true\", states of points, or no inMatrix");
    if (meet_ == Meet::halfway && !ofPoints()) warn("meet=\"halfway\" has no effect: it is of points", "no meet");
    tellOfTurns();
    tellOfFreeSurface();
  }

  std::vector<State*> states() const override { return {&state(), second_}; }
  bool prescribesMotion() const override { return !two_way_ || leavesMatrix(); }
  bool leavesMatrix() const override { return two_way_ && !in_matrix_; }
  void projectRightSide(Rows b) const override {
    forEachRow([&](Index one, Index other) { b[one] = b[other] = Vec3((b[one] + b[other]) / 2); });
  }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    if (!two_way_) forEachRow([&](Index, Index follower) { out.push_back({follower, Mat3::Zero()}); });
    if (leavesMatrix())
      forEachRow([&](Index one, Index other) { out.insert(out.end(), {{one, Mat3::Identity()}, {other, Mat3::Identity()}}); });
  }
  void addTies(std::vector<Tie>& out) const override {
    if (two_way_ && in_matrix_) forEachRow([&](Index leader, Index follower) { out.push_back({leader, follower}); });
  }
  void addUnansweredRows(std::vector<Index>& out) const override {
    if (!two_way_) forEachRow([&](Index, Index follower) { out.push_back(follower); });
  }
  bool keepsStartVelocity() const override { return meetsHalfway(); }
  void placeStart(double t, Rows x, Rows v) const override {
    if (!activeIn(t, t)) return;  // SOFA projects before the first step too
    if (two_way_ && meet_ == Meet::halfway && ofPoints()) join(x, v);
    if (!meetsHalfway()) return;
    forEachRow([&](Index leader, Index follower) {
      x[follower] = (x[leader] + x[follower]) / 2;
      v[leader] = v[follower] = Vec3((v[leader] + v[follower]) / 2);
    });
  }
  void beginMotion(double, ConstRows x) override {
    if (!meetsHalfway()) return;
    freely_.clear();
    forEachRow([&](Index, Index follower) {
      freely_.push_back(x[follower] + node().dt() * second_->v()[follower - second_->firstRow()]);
    });
  }
  void prescribe(double, Rows x, Rows v) const override {
    if (leavesMatrix()) join(x, v);
    if (two_way_) return;
    if (meetsHalfway()) return meet(x, v);
    forEachRow([&](Index leader, Index follower) {
      std::copy_n(x.data + std::size_t(leader) * row_doubles, row_doubles, x.data + std::size_t(follower) * row_doubles);
      v[follower] = Vec3(v[leader]);
    });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  /// How many rows the nodes of both states have in common.
  Index sharedRows() const {
    const bool numbers = state().kindOf(0) == RowKind::value, others = second_->kindOf(0) == RowKind::value;
    if (numbers != others || (numbers && state().rows_per_node != second_->rows_per_node))
      throw ComponentError(fmt::format("the nodes of {} and {} are of different types", state().path(), second_->path()),
                           "states of one template, or points and frames");
    return std::min(state().rows_per_node, second_->rows_per_node);
  }
  bool ofPoints() const { return rows_ == 1 && state().kindOf(0) == RowKind::place; }
  bool meetsHalfway() const { return !two_way_ && meet_ == Meet::halfway && ofPoints(); }
  void join(Rows x, Rows v) const {
    forEachRow([&](Index one, Index other) {
      x[one] = x[other] = Vec3((x[one] + x[other]) / 2);
      v[one] = v[other] = Vec3((v[one] + v[other]) / 2);
    });
  }
  /// May be done again: the followers' own ways are those of beginMotion(), and means of equal velocities are equal.
  void meet(Rows x, Rows v) const {
    std::size_t i = 0;
    forEachRow([&](Index leader, Index follower) {
      x[follower] = (x[leader] + freely_[i++]) / 2;
      v[leader] = v[follower] = Vec3((v[leader] + v[follower]) / 2);
    });
  }
  /// One surface is joined as a whole, the other at single nodes.
  void tellOfFreeSurface() const {
    const FacesOf first(state(), leaders_), second(*second_, followers_);
    if (second_ == &state() || !first.cells || !second.cells || first.whole == second.whole) return;
    const State &fine = first.whole ? *second_ : state(), &coarse = first.whole ? state() : *second_;
    warn(fmt::format("{} is attached by single nodes, and no face of its cells has all its corners among them: the surface between "
                     "them is free, and gives way more than that of one body would",
                     fine.path()),
         fmt::format("springs from all nodes there to points that a BarycentricMapping places in {}", coarse.path()));
  }
  void tellOfTurns() const {
    if (rows_ != 2 || !state().hasFrames()) return;
    double most = 0;
    for (std::size_t i = 0; i < leaders_.size(); ++i)
      most = std::max(most, turnedBy(state().position[std::size_t(leaders_[i] + 1)])
                                .angularDistance(turnedBy(second_->position[std::size_t(followers_[i] + 1)])));
    if (most > 1e-9)
      inform(fmt::format("attached frames are turned up to {:.3g} rad against each other: they get one orientation", most));
  }
  /// Rows of the system that are one.
  template <class Visit>
  void forEachRow(Visit&& visit) const {
    for (std::size_t i = 0; i < leaders_.size(); ++i)
      for (Index k = 0; k < rows_; ++k)
        visit(state().firstRow() + leaders_[i] + k, second_->firstRow() + followers_[i] + k);
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::vector<int> indices1_, indices2_;
  bool two_way_ = true, in_matrix_ = true;
  enum class Meet { leader, halfway } meet_ = Meet::leader;
  std::vector<Vec3> freely_;  ///< where followers go by themselves in the step [m], shape (pairs)
  State* second_ = nullptr;
  std::vector<Index> leaders_, followers_;  ///< first rows of the nodes, shape (pairs)
  Index rows_ = 1;                          ///< of a node that are shared
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(attach_projective_constraint) {
  factory.add<stroma::AttachProjectiveConstraint>("AttachProjectiveConstraint", "Makes pairs of nodes one node");
}
