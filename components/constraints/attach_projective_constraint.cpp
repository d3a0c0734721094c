// SPDX-License-Identifier: LGPL-2.1-or-later
// AttachProjectiveConstraint: pairs of nodes, of two bodies or of one, that become one node.
//
// Both ends of a pair have one velocity, and their masses and forces add up, exactly: with P the mean over the pair, the step
// solves P (m M + k K + c C) P. Two bodies attached at matching nodes are the merged body. Ends with different initial
// positions are moved to their mass-weighted mean, and so are their velocities; in directions in which another constraint
// fixes one end, to that end.
//
// twoWay="false" (the default of SOFA): the nodes of indices2 follow those of indices1, without reaction on these. Positions
// and velocities coincide at the end of every step; inside a step the follower moves with the velocity that the other had at
// its start. The weight of a body that hangs or rests only on its followers is then not transmitted: a run reports the size of
// the missing force.
//
// With twoWay="false", meet="halfway" does what SOFA does with points: in a step the follower keeps its velocity; then
//
//   c = (v2 - v1) velocityFactor k / 2,  v1 += c,  v2 -= c,   x2 -= (x2 - x1) positionFactor k / 2
//
// with k the pair's constraintFactor. This affects the followed node: it loses half of its acceleration. With twoWay, points
// that start apart are moved to the first one; with inMatrix="false" the right side of the step has b1 += c, b2 -= c, with
// responseFactor.
//
// A pair is released while (x1 - lastPos) . lastDir > 0; with clamp its second node is then fixed at lastPos. A pair is also
// released while its nodes are farther apart than minDistance. This holds for followers and inMatrix="false" only: two-way
// pairs are permanent.
//
// Rigid frames that are attached are one body: the sum of their masses and inertias, with one orientation, their mean at the
// start. A frame and a point share the frame's centre. With freeRotations frames share only their centres, with
// lastFreeRotation only those of the last pair, the one before a released pair. With restRotations a follower is rotated
// against the followed frame by the rotation that takes the rest direction to the next node, in its own axes, to x.
//
// If one body has a finer mesh, pairs of nodes join its surface at single nodes and leave the rest free: the joint is then too
// soft, and a warning is printed. To join the whole surface, use stiff springs between all nodes of the finer surface and
// points that a BarycentricMapping embeds in the other body.
//
// Node indices1[i] of object1 is attached to node indices2[i] of object2; without the objects both belong to the state of this
// node. Bodies with separate integrators move in one system, by the first of them, and a warning says where the integrators
// differ. A node may be attached to several others.
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
#include <cmath>
#include <tuple>

#include "framework/mechanics/signs.h"
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
    table.addLink("object1", object1_).help("state of indices1; the one of this node by default");
    table.addLink("object2", object2_).help("state of indices2; that of object1 by default");
    table.add("indices1", indices1_).help("nodes of object1, one for each pair").required();
    table.add("indices2", indices2_).help("nodes of object2, one for each pair").required();
    table.add("twoWay", two_way_)
        .help(
            "both ends share mass and forces; false, SOFA's default: the second follows without acting on the first");
    table.addChoice("meet", meet_, {"leader", "halfway"})
        .help("where points go that follow without being felt: where those go that they follow, or halfway there, as in SOFA");
    table.add("inMatrix", in_matrix_)
        .help("with twoWay, of points, false: both ends are free in the matrix of an implicit step of one linear solve, whose right side "
              "has their mean, and meet after it: SOFA's way with assembled matrices");
    table.add("positionFactor", position_factor_).help("fraction of the way to the followed node, with meet=halfway")
        .unit("-").min(0).max(1);
    table.add("velocityFactor", velocity_factor_).help("of the change of both velocities, with meet=halfway").unit("-").min(0).max(1);
    table.add("responseFactor", response_factor_).help("of the change of both right sides, with inMatrix=false").unit("-").min(0).max(1);
    table.add("constraintFactor", pair_factors_).help("of all three, one for each pair; 1 by default").unit("-").min(0).max(1);
    table.add("lastPos", last_place_).help("where a pair comes free that goes along lastDir").unit("m");
    table.add("lastDir", last_way_).help("zero: pairs are never released").unit("-");
    table.add("clamp", clamp_).help("the second node of a pair past lastPos stays there instead of being released");
    table.add("minDistance", min_distance_).help("pairs farther apart are free; -1: none is").unit("m");
    table.add("freeRotations", free_turns_).help("frames share centres, and turn by themselves");
    table.add("lastFreeRotation", last_free_turn_).help("the frame of the last pair turns by itself");
    table.add("restRotations", rest_turns_wanted_).help("frames follow with the turn that they have to the next one at rest");
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ProjectiveConstraint::init();
    second_ = object2_.get() ? object2_.get() : &state();
    std::tie(leaders_, followers_) = checkedPairs({"indices1", indices1_, state()}, {"indices2", indices2_, *second_});
    rows_ = sharedRows();
    checkWays();
    freely_.assign(leaders_.size(), {});
    bonds_.assign(leaders_.size(), Bond::leader);
    placed_.reserve(4 * leaders_.size());
    double farthest = 0;
    for (std::size_t i = 0; i < leaders_.size(); ++i) {
      if (second_ == &state() && leaders_[i] == followers_[i])
        throw ComponentError(fmt::format("node {} is attached to itself", leaders_[i] / state().rows_per_node),
                             "two different nodes");
      farthest = std::max(farthest, (state().position[leaders_[i]] - second_->position[followers_[i]]).norm());
    }
    if (!data().find("twoWay")->isSet())
      inform("twoWay is not given: both ends act on each other; in SOFA the second follows without acting on the first");
    else if (!two_way_)
      inform(
          fmt::format("{} is not affected by the nodes that follow it: the force on the nodes of {} is not transmitted",
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
  bool isConstant() const override { return !changes(); }
  bool prescribesMotion() const override { return !two_way_ || leavesMatrix(); }
  bool leavesMatrix() const override { return two_way_ && !in_matrix_; }
  void projectRightSide(Rows b) const override {
    for (std::size_t i = 0; i < leaders_.size(); ++i) {
      const Bond bond = bondNow(i);
      const double share = halfOf(response_factor_, i);
      const Vec3 change = share * (Vec3(b[follower(i)]) - Vec3(b[leader(i)]));
      if (bond == Bond::clamped) b[follower(i)] = Vec3::Zero();
      if (bond == Bond::leader) b[leader(i)] += change, b[follower(i)] -= change;
    }
  }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    if (!prescribesMotion()) return;
    for (std::size_t i = 0; i < leaders_.size(); ++i) {
      const Bond bond = changes() ? bondNow(i) : Bond::leader;
      const bool held = !leavesMatrix() && bond != Bond::none;
      for (Index k = 0; k < rowsOf(i, bond); ++k)
        out.push_back({follower(i) + k, held ? Mat3(Mat3::Zero()) : Mat3(Mat3::Identity())});
      if (leavesMatrix()) out.push_back({leader(i), Mat3::Identity()});
    }
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
    if (prescribesMotion()) return placeAll(x, v);
    if (meet_ != Meet::halfway || !ofPoints()) return;
    forEachRow([&](Index leader, Index follower) {
      x[follower] = Vec3(x[leader]);
      v[leader] = v[follower] = Vec3((v[leader] + v[follower]) / 2);
    });
  }
  void beginMotion(double t, ConstRows x) override {
    begun_ = t;
    placed_.clear();
    for (std::size_t i = 0; i < leaders_.size(); ++i) {
      const Vec3 v = second_->v()[follower(i) - second_->firstRow()];
      freely_[i] = {meetsHalfway() && bondOf(x[leader(i)], x[follower(i)]) != Bond::none, x[follower(i)] + node().dt() * v, v};
    }
  }
  /// May be done again: what it has led to is remembered, and left as it is.
  void prescribe(double t, Rows x, Rows v) const override {
    if (!prescribesMotion() || (sharesWays() && (t == begun_ || isPlaced(x, v)))) return;
    for (std::size_t i = 0; i < leaders_.size(); ++i)
      if (freely_[i].is_own) x[follower(i)] = freely_[i].place, v[follower(i)] = freely_[i].velocity;
    placeAll(x, v);
    placed_.clear();
    forEachPlaced(x, v, [this](const Vec3& each) { placed_.push_back(each); });
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
    return free_turns_ && !numbers ? 1 : std::min(state().rows_per_node, second_->rows_per_node);
  }
  /// What the second node of a pair is bound to.
  enum class Bond : char { leader, clamped, none };
  struct Freely {
    bool is_own = false;                  ///< it goes on by itself in the step
    Vec3 place = Vec3::Zero(), velocity = Vec3::Zero();  ///< at its end [m], [m/s]
  };
  bool changes() const { return !last_way_.isZero(0) || min_distance_ != -1; }
  double pastBy(const Vec3& one) const { return (one - last_place_).dot(last_way_); }
  bool isPast(const Vec3& one) const { return !last_way_.isZero(0) && pastBy(one) > 0; }
  Bond bondOf(const Vec3& one, const Vec3& other) const {
    if (!changes()) return Bond::leader;
    const bool is_past = isPast(one);
    if (is_past && !clamp_) return Bond::none;
    if (min_distance_ != -1 && (other - (is_past ? last_place_ : one)).norm() > min_distance_) return Bond::none;
    return is_past ? Bond::clamped : Bond::leader;
  }
  Vec3 placeOf(const State& of, Index row) const { return of.isBound() ? Vec3(of.x()[row]) : of.position[std::size_t(row)]; }
  Bond bondNow(std::size_t i) const { return bondOf(placeOf(state(), leaders_[i]), placeOf(*second_, followers_[i])); }
  Index leader(std::size_t i) const { return state().firstRow() + leaders_[i]; }
  Index follower(std::size_t i) const { return second_->firstRow() + followers_[i]; }
  double halfOf(double factor, std::size_t i) const { return factor * (pair_factors_.empty() ? 1 : pair_factors_[i]) / 2; }
  /// How many rows of its second node a pair holds.
  Index rowsOf(std::size_t i, Bond bond) const {
    if (!last_free_turn_ || bond == Bond::clamped || !state().hasFrames()) return rows_;
    const bool is_last = i + 1 == leaders_.size() || isPast(placeOf(state(), leaders_[i + 1]));
    return is_last ? 1 : rows_;
  }
  bool ofPoints() const { return rows_ == 1 && state().kindOf(0) == RowKind::place; }
  bool meetsHalfway() const { return !two_way_ && meet_ == Meet::halfway && ofPoints(); }
  /// Both nodes of a pair move to each other.
  bool sharesWays() const { return meetsHalfway() || leavesMatrix(); }
  template <class Visit>
  void forEachPlaced(ConstRows x, ConstRows v, Visit&& visit) const {
    for (std::size_t i = 0; i < leaders_.size(); ++i)
      for (const Vec3& each : {Vec3(x[follower(i)]), Vec3(x[leader(i)]), Vec3(v[follower(i)]), Vec3(v[leader(i)])}) visit(each);
  }
  bool isPlaced(ConstRows x, ConstRows v) const {
    if (placed_.empty()) return false;
    std::size_t at = 0;
    bool same = true;
    forEachPlaced(x, v, [&](const Vec3& each) { same = same && each == placed_[at++]; });
    return same;
  }
  /// All pairs, one after another; which of them are free is seen before.
  void placeAll(Rows x, Rows v) const {
    for (std::size_t i = 0; i < leaders_.size(); ++i) bonds_[i] = bondOf(x[leader(i)], x[follower(i)]);
    for (std::size_t i = 0; i < leaders_.size(); ++i)
      if (bonds_[i] != Bond::none) sharesWays() ? bringNearer(i, x, v) : bringThere(i, x, v);
  }
  void bringNearer(std::size_t i, Rows x, Rows v) const {
    const bool clamped = bonds_[i] == Bond::clamped;
    const Index one = leader(i), other = follower(i);
    const Vec3 goal = clamped ? last_place_ : Vec3(x[one]), speed = clamped ? Vec3(Vec3::Zero()) : Vec3(v[one]);
    const Vec3 change = halfOf(velocity_factor_, i) * (Vec3(v[other]) - speed);
    x[other] -= halfOf(position_factor_, i) * (Vec3(x[other]) - goal);
    v[other] -= change;
    if (!clamped) v[one] += change;
  }
  void bringThere(std::size_t i, Rows x, Rows v) const {
    const bool clamped = bonds_[i] == Bond::clamped;
    for (Index k = 0; k < rowsOf(i, bonds_[i]); ++k) {
      const Index one = leader(i) + k, other = follower(i) + k;
      std::copy_n(x.data + std::size_t(one) * row_doubles, row_doubles, x.data + std::size_t(other) * row_doubles);
      v[other] = clamped ? Vec3(Vec3::Zero()) : Vec3(v[one]);
      if (k == 1 && !rest_turns_.empty()) putNearest(orientationIn(x, one) * restTurn(i, x), x, other);
    }
    if (clamped) x[follower(i)] = last_place_;
  }
  /// Of the pair whose next one is free a part: as much of the way between both as lies before lastPos.
  Quaternion restTurn(std::size_t i, ConstRows x) const {
    if (i + 1 >= leaders_.size() || !isPast(x[leader(i + 1)])) return rest_turns_[i];
    const double from = pastBy(x[leader(i)]), to = pastBy(x[leader(i + 1)]);
    const Eigen::AngleAxisd turn(rest_turns_[i]);
    return Quaternion(Eigen::AngleAxisd(-from / (to - from) * turn.angle(), turn.axis()));
  }
  /// Attributes that say how pairs meet and when they part.
  void checkWays() {
    const auto refuse = [this](const char* what, const char* expected) { throw ComponentError(what, expected); };
    const bool numbers = state().kindOf(0) == RowKind::value, frames = state().hasFrames() && second_->hasFrames();
    if (!pair_factors_.empty() && pair_factors_.size() != leaders_.size())
      throw ComponentError(fmt::format("constraintFactor has {} values for {} pairs", pair_factors_.size(), leaders_.size()), "one each");
    const auto isBelow = [this](double factor) {
      for (std::size_t i = 0; i < leaders_.size(); ++i)
        if (halfOf(factor, i) != 0.5) return true;
      return false;
    };
    if (!sharesWays() && !frames && (isBelow(position_factor_) || isBelow(velocity_factor_)))
      refuse("factors below 1 are of points that meet halfway", "meet=\"halfway\" without twoWay, or inMatrix=\"false\"");
    if (two_way_ && in_matrix_ && !frames && isBelow(response_factor_))
      refuse("a responseFactor below 1 is of nodes that are free in the matrix", "inMatrix=\"false\", or no twoWay");
    if (changes() && (numbers || (two_way_ && in_matrix_)))
      refuse("lastDir and minDistance are of points and frames that follow", "no twoWay, or inMatrix=\"false\"");
    if (rest_turns_wanted_ && frames && two_way_) refuse("restRotations is of frames that follow", "no twoWay");
    if (last_free_turn_ && frames && two_way_) refuse("lastFreeRotation is of frames that follow", "no twoWay, or freeRotations");
    if (rest_turns_wanted_ && frames) findRestTurns();
  }
  void findRestTurns() {
    const auto& rest = second_->rest_position;
    for (const Index row : followers_) {
      Quaternion turn = Quaternion::Identity();
      if (std::size_t(row) + 2 < rest.size()) {
        const Vec3 apart = rest[std::size_t(row) + 2] - rest[std::size_t(row)];
        const Vec3 way = (turnedBy(rest[std::size_t(row) + 1]).conjugate() * apart).normalized();
        const Vec3 axis = way.cross(Vec3::UnitX());  // SOFA's, of a turn by the angle between both
        if (axis.norm() > 1e-12) turn = Eigen::AngleAxisd(std::acos(std::clamp(way.x(), -1., 1.)), axis.normalized());
      }
      rest_turns_.push_back(turn);
    }
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
  double position_factor_ = 1, velocity_factor_ = 1, response_factor_ = 1, min_distance_ = -1;
  std::vector<double> pair_factors_;
  Vec3 last_place_ = Vec3::Zero(), last_way_ = Vec3::Zero();
  bool clamp_ = false, free_turns_ = false, last_free_turn_ = false, rest_turns_wanted_ = false;
  std::vector<Quaternion> rest_turns_;   ///< of followers to what they follow, shape (pairs) or none
  std::vector<Freely> freely_;           ///< shape (pairs)
  double begun_ = -1;                    ///< where the step began [s]
  mutable std::vector<Bond> bonds_;      ///< shape (pairs)
  mutable std::vector<Vec3> placed_;     ///< what prescribe() has led to, shape (4 pairs)
  State* second_ = nullptr;
  std::vector<Index> leaders_, followers_;  ///< first rows of the nodes, shape (pairs)
  Index rows_ = 1;                          ///< of a node that are shared
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(attach_projective_constraint) {
  factory.add<stroma::AttachProjectiveConstraint>("AttachProjectiveConstraint", "Makes pairs of nodes one node");
}
