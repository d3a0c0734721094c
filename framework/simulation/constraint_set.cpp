// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/constraint_set.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

namespace {

bool same(const std::vector<NodeProjector>& a, const std::vector<NodeProjector>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const NodeProjector& p, const NodeProjector& q) { return p.row == q.row && p.projector == q.projector; });
}

/// Its component and its first nodes.
std::string describeRelation(const Actors& actors, const LinearRelations& relations, Index relation) {
  const LinearRelations::Term *begin = relations.begin(relation), *end = relations.end(relation);
  const auto is_of = [&](const ProjectiveConstraint* constraint) {
    LinearRelations own;
    constraint->addRelations(own);
    return std::search(own.terms.begin(), own.terms.end(), begin, end) != own.terms.end();
  };
  const auto owner = std::find_if(actors.constraints.begin(), actors.constraints.end(), is_of);
  std::string nodes;
  for (auto term = begin; term != end && term != begin + 3; ++term)
    nodes += (nodes.empty() ? "" : ", ") + actors.describeRow(term->row);
  if (end > begin + 3) nodes += ", ...";
  return fmt::format("{}: the relation of {}", (*owner)->path(), nodes);
}

void applyProjectors(const std::vector<NodeProjector>& projectors, Rows vector) {
  for (const NodeProjector& held : projectors) vector[held.row] = (held.projector * vector[held.row]).eval();
}

}  // namespace

ConstraintSet::ConstraintSet(const Actors& actors) : actors_(actors), motion_(actors, groups_) {}

void ConstraintSet::compile(double start, Rows x, Rows v) {
  projector_of_row_.assign(std::size_t(actors_.independent_rows), -1);
  for (const ProjectiveConstraint* constraint : all()) change_ = change_ || !constraint->isConstant() || constraint->endTime() >= 0;
  reserve(start);
  for (const ProjectiveConstraint* constraint : all()) constraint->placeStart(start, x, v);
  gather(start, start);
  refuseTurningRows();
  motion_.check(start, x, v);
  meetGroups(start, x, v);
  placeRelations(x, v);
  if (!broken_.empty()) throw ComponentError(broken_, "fixed nodes that satisfy the relation");
}

// Room for all constraints at once, so that one that begins later allocates nothing.
void ConstraintSet::reserve(double start) {
  std::vector<NodeProjector> every;
  bool prescribed = false;
  for (const ProjectiveConstraint* constraint : all()) {
    constraint->addProjectors(start, every);
    constraint->addTies(gathered_ties_);
    constraint->addRelations(gathered_relations_);
    prescribed = prescribed || constraint->prescribesMotion();
  }
  holdUnusedDirections(every);
  const std::size_t most = every.size() + 2 * gathered_ties_.size();
  for (std::vector<NodeProjector>* list : {&gathered_, &projectors_, &velocity_projectors_}) list->reserve(most);
  if (prescribed) motion_.reserve(most);
}

// A row that is one number moves along x only.
void ConstraintSet::holdUnusedDirections(std::vector<NodeProjector>& out) const {
  for (const State* state : actors_.states)
    for (Index i = 0; state->firstRow() < actors_.independent_rows && i < Index(state->row_kinds.size()); ++i)
      if (state->row_kinds[std::size_t(i)] == RowKind::value) out.push_back({state->firstRow() + i, Vec3::UnitX().asDiagonal()});
}

// A constraint holds in a step that starts before its endTime (as in SOFA); its projectors are those of the step's end.
void ConstraintSet::gather(double t_start, double t_end) {
  gathered_.clear();
  velocity_projectors_.clear();
  gathered_ties_.clear();
  motion_.clear();
  for (std::size_t i = 0; i < all().size(); ++i) {
    const ProjectiveConstraint* constraint = all()[i];
    if (!constraint->activeIn(t_start, t_end)) continue;
    constraint->addProjectors(t_end, gathered_);
    constraint->addTies(gathered_ties_);
    if (constraint->projectsVelocity()) constraint->addProjectors(t_end, velocity_projectors_);
    if (constraint->prescribesMotion()) motion_.add(i, t_end);
  }
  holdUnusedDirections(gathered_);
  const bool regrouped = groups_.set(gathered_ties_, actors_.independent_rows);
  if (regrouped) updateInverseMass();
  motion_.finish();
  for (std::vector<NodeProjector>* list : {&gathered_, &velocity_projectors_}) {
    mergeByRow(*list);
    groups_.share(*list);
  }
  const bool held_again = !same(gathered_, projectors_);
  if (held_again) {
    for (const NodeProjector& held : projectors_) projector_of_row_[std::size_t(held.row)] = -1;
    projectors_.swap(gathered_);
    for (std::size_t i = 0; i < projectors_.size(); ++i) projector_of_row_[std::size_t(projectors_[i].row)] = Index(i);
  }
  const bool other_relations = gatherRelations(t_start, t_end);
  if (other_relations || (!relations_.empty() && (held_again || regrouped)))
    relations_.set(gathered_relations_, projectors_, groups_, relationWeights());
  revision_ += held_again || regrouped || other_relations;
}

bool ConstraintSet::gatherRelations(double t_start, double t_end) {
  gathered_relations_.clear();
  for (const ProjectiveConstraint* constraint : all())
    if (constraint->activeIn(t_start, t_end)) constraint->addRelations(gathered_relations_);
  return !(gathered_relations_ == relations_.relations());
}

void ConstraintSet::resume(const StepContext& last) { if (change_ && last.index > 0) gather(last.t, last.t_end); }

void ConstraintSet::begin(const StepContext& context, ConstRows x, Rows v) {
  motion_.forgetMisplaced();
  broken_.clear();
  if (change_) gather(context.t, context.t_end);
  applyProjectors(velocity_projectors_, v);
  motion_.aim(context, x, v);
  relations_.correctVelocities(v);
}

bool ConstraintSet::end(const StepContext& context, Rows x, Rows v) const {
  if (motion_.empty() && groups_.empty() && relations_.empty()) return false;
  // what a direct solve leaves between tied rows is round-off; it must not add up
  groups_.averagePositions(actors_.motion, x);
  groups_.average(v);
  placePrescribed(context, context.t_end, x, v);
  return true;
}

void ConstraintSet::placePrescribed(const StepContext& context, double t, Rows x, Rows v) const {
  motion_.place(context, t, x, v);
  placeRelations(x, v);
}

// What is left after the correction belongs to held nodes: no motion of the free ones takes it away.
void ConstraintSet::placeRelations(Rows x, Rows v) const {
  if (relations_.empty()) return;
  relations_.correctPositions(x);
  relations_.correctVelocities(v);
  const RelationClusters::Violation worst = relations_.worst(x);
  double largest = 0;
  for (const LinearRelations::Term& term : relations_.relations().terms)
    largest = std::max({largest, x[term.row].lpNorm<Eigen::Infinity>(), term.rest.lpNorm<Eigen::Infinity>()});
  broken_.clear();
  if (worst.distance > 1e-9 * largest)  // and not for NaN, which others name
    broken_ = fmt::format("{} cannot be satisfied: its nodes are fixed {:.3g} m away from where it holds",
                          describeRelation(actors_, relations_.relations(), worst.relation), worst.distance);
}

void ConstraintSet::project(Rows vector) const {
  applyProjectors(projectors_, vector);
  groups_.average(vector);
  relations_.project(vector);
}

void ConstraintSet::projectAcceleration(Rows a) const {
  applyProjectors(projectors_, a);
  groups_.average(a);
  relations_.projectAcceleration(a);
}

// Rows that are held at all times never mix others; those that are held for a while, be it by a tie to a held one, will.
NodeGroups ConstraintSet::mixedRows() const {
  std::vector<Tie> ties;
  LinearRelations relations;
  std::vector<NodeProjector> always;
  for (const ProjectiveConstraint* constraint : all()) {
    constraint->addTies(ties);
    constraint->addRelations(relations);
    if (constraint->isConstant() && constraint->endTime() < 0) constraint->addProjectors(0, always);
  }
  NodeGroups groups;
  groups.set(ties, actors_.independent_rows);
  if (relations.count() == 0) return groups;
  mergeByRow(always);
  RelationClusters clusters;
  clusters.set(relations, always, groups, {});
  clusters.addTies(ties);
  groups.set(ties, actors_.independent_rows);
  return groups;
}

}  // namespace stroma
