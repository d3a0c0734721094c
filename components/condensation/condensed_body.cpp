// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/condensation/condensed_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/system_report.h"

namespace stroma {

void CondensedBody::collect(System& system, const OtherBodies& others, const Integrator& integrator,
                            const CondensationChoice& choice) {
  system_ = &system, others_ = &others;
  refuseOtherKinds(integrator, choice.dynamic);
  sortFields(choice.dynamic);
  for (const Mass* mass : system.masses())
    if (choice.dynamic && !mass->isDiagonal() && !others.has(*mass))
      notes_.push_back(fmt::format("the sparse matrix of {} is lumped to its sums of rows, as {} has it", mass->path(),
                                   integrator.type()));
  const Index count = system.independentRows();
  for (Vector* vector : {&reference_, &rest_, &still_, &timed_force_}) vector->resize(count);
  copy(system.x.head(count), reference_);
  for (const State* state : system.states())
    if (state->firstRow() < count)  // else it only follows
      for (Index i = 0; i < state->size(); ++i) rest_[state->firstRow() + i] = state->rest_position[i];
  findHeld();
  const std::vector<char> kept = keptRows(integrator, choice);
  std::vector<char> is_held(std::size_t(count), 0);
  for (const NodeProjector& held : held_) is_held[held.row] = held.projector.isZero();
  for (Index row = 0; row < count; ++row) is_held[row] |= others.hasRow(row);
  rows_.clear();
  node_of_row_.assign(count, -1);
  for (const char wanted : {0, 1}) {
    for (Index row = 0; row < count; ++row)
      if (!is_held[row] && kept[row] == wanted) rows_.push_back(row);
    if (!wanted) interior_ = Index(rows_.size());
  }
  for (Index node = 0; node < free(); ++node) node_of_row_[row(node)] = node;
  if (rows_.empty()) throw ComponentError("every node is fixed: there is nothing to solve for", "a node that can move");
  findTimedNodes();
}

/// Tried out: a force may read v and have no C.
bool readsVelocity(ForceField& field, const System& system) {
  if (field.traits().velocity_dependent) return true;
  Vector v(system.allRows()), still(system.allRows()), moving(system.allRows());
  for (Vector* vector : {&v, &still, &moving}) clear(*vector);
  field.addForce(system.x, v, still);
  for (Index i = 0; i < v.count(); ++i) v[i] = Vec3(i + 1, 2 * i + 1, 3 * i + 2);
  field.addForce(system.x, v, moving);
  return distance(still, moving) > 0;
}

void CondensedBody::refuseOtherKinds(const Integrator& integrator, bool dynamic) {
  const System& system = *system_;
  const std::string& name = integrator.type();
  for (const Mapping* mapping : system.actors().mappings)
    if (!others_->has(mapping->output()))
      throw ComponentError(fmt::format("{} takes no forces through mappings, and something acts on the nodes of {}", name, mapping->path()),
                           "mapped nodes that only follow");
  if (!system.actors().position_constraints.empty())
    throw ComponentError(fmt::format("{} corrects positions, and {} has one matrix for all times",
                                     system.actors().position_constraints.front()->path(), name),
                         "no position constraints", dynamic ? "use EulerImplicitSolver" : "use projective constraints");
  if (!system.constraints().relations().empty())
    throw ComponentError(fmt::format("{} does not know linear relations between displacements", name),
                         "no linear relations", dynamic ? "use EulerImplicitSolver" : "use StaticSolver");
  std::vector<Tie> ties;
  for (const ProjectiveConstraint* constraint : system.constraints().all()) {
    constraint->addTies(ties);
    if (!ties.empty())
      throw ComponentError(fmt::format("{} makes nodes one, which {} does not do", constraint->path(), name),
                           "one mesh for bodies that are attached, or an integrator that makes its matrix in steps");
    if (constraint->prescribesMotion() && constraint->states().size() > 1)
      throw ComponentError(fmt::format("{} lets nodes follow others, which {} does not do", constraint->path(), name),
                           "motions given in time, or an integrator that makes its matrix in steps");
  }
  if (!dynamic) return refuseRayleighFactors(system, "statics");
  for (ForceField* field : system.forceFields()) {
    if (others_->has(*field)) continue;
    if (field->rayleigh_stiffness != 0)
      throw ComponentError(
          fmt::format("{} has rayleighStiffness, but {} only supports damping by masses", field->path(), name),
          "rayleighMass of the solver", "rayleighStiffness=\"0\"");
    if (!dynamic_cast<const StepListener*>(field) && readsVelocity(*field, system))
      throw ComponentError(fmt::format("{} depends on velocity, but {} only supports damping by masses", field->path(), name),
                           "rayleighMass of the solver");
  }
}

void CondensedBody::sortFields(bool dynamic) {
  for (ForceField* field : system_->forceFields()) {
    if (others_->has(*field)) continue;
    const ForceTraits traits = field->traits();
    const auto* load = dynamic_cast<const LocalLoad*>(field);
    if (dynamic_cast<const LagrangianConstraint*>(field) && !traits.has_stiffness) continue;  // its conditions act
    if (dynamic_cast<const StepListener*>(field)) {
      contacts_.push_back(field);
      continue;
    }
    if (load && load->isDeadLoadToFirstOrder()) {
      dead_.push_back(field);
      notes_.push_back(fmt::format("{} is taken for a dead load on the surface at rest, as linear elasticity has it",
                                   field->path()));
    } else if (!traits.linear || (traits.has_stiffness && !(traits.constant_stiffness && traits.symmetric))) {
      const bool has_method = field->data().find("method") != nullptr;
      throw ComponentError(
          fmt::format("the force of {} is not linear, and a condensed body has one matrix for all times",
                      field->path()),
          "force fields whose stiffness is constant", has_method ? "method=\"small\"" : "");
    } else if (traits.has_stiffness) {
      stiff_.push_back(field);
    }
    (traits.time_dependent ? timed_ : constant_).push_back(field);
  }
  if (stiff_.empty() && !dynamic)
    throw ComponentError("no force field has a stiffness: there is no equilibrium to solve for",
                         "an elastic force field", "add <TetrahedronFEMForceField method=\"small\"/>");
}

// ---- rows ----

void CondensedBody::findHeld() {
  moving_.assign(system_->independentRows(), 0);
  const double start = system_->node().root().root_time;
  std::vector<NodeProjector> found;
  for (const ProjectiveConstraint* constraint : system_->constraints().all()) {
    if (others_->has(constraint->state())) continue;
    if (constraint->isConstant() && constraint->endTime() < 0 && !constraint->prescribesMotion()) {
      constraint->addProjectors(start, held_);
      continue;
    }
    constraints_are_fixed_ = constraints_are_fixed_ && constraint->isConstant() && constraint->endTime() < 0;
    constraint->addProjectors(start, found);
  }
  for (const NodeProjector& held : found) moving_[held.row] = 1, moves_ = true;
  std::sort(held_.begin(), held_.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
  std::vector<NodeProjector> merged;
  for (const NodeProjector& held : held_) {
    if (!merged.empty() && merged.back().row == held.row) {
      merged.back().projector = intersection(merged.back().projector, held.projector);
    } else {
      merged.push_back(held);
    }
  }
  std::erase_if(merged, [&](const NodeProjector& held) { return moving_[held.row] && held.projector.isZero(); });
  held_ = std::move(merged);
}

Mat3 CondensedBody::projector(Index node) const {
  const auto at = std::lower_bound(held_.begin(), held_.end(), row(node),
                                   [](const NodeProjector& held, Index wanted) { return held.row < wanted; });
  return at != held_.end() && at->row == row(node) ? at->projector : Mat3::Identity();
}

void CondensedBody::markBoundary(const State& state, std::vector<char>& kept) {
  const auto keep = [&](Index node) { kept[state.firstRow() + node] = 1; };
  const Topology* topology = topologyOf(state);
  const bool has_cells = topology && highestDimension(topology->mesh()) == 3;
  if (!has_cells) {
    notes_.push_back(fmt::format("{} has no volume cells: all its nodes are kept", state.path()));
    for (Index node = 0; node < state.size(); ++node) keep(node);
    return;
  }
  for (const Triangle& face : topology->mesh().boundaryTriangles())
    for (const Index node : face) keep(node);
  for (const Quad& face : topology->mesh().boundaryQuads())
    for (const Index node : face) keep(node);
}

std::vector<char> CondensedBody::keptRows(const Integrator& integrator, const CondensationChoice& choice) {
  std::vector<char> kept(std::size_t(system_->independentRows()), choice.condensed ? 0 : 1);
  const bool named = integrator.data().find("surfaceIndices")->isSet();
  if (named && !choice.condensed)
    throw ComponentError("surfaceIndices is given, and condensed=\"false\" keeps every node", "one of the two");
  const auto bodies = std::count_if(system_->states().begin(), system_->states().end(), [this](const State* state) {
    return state->firstRow() < system_->independentRows() && !others_->has(*state);
  });
  if (named && bodies > 1)
    throw ComponentError(fmt::format("surfaceIndices names nodes of one state, and there are {}", bodies),
                         "a solver for each body");
  if (!choice.condensed) return kept;
  std::vector<Observer*> observers;
  system_->node().root().collect(observers);
  for (const State* state : system_->states()) {
    if (state->firstRow() >= system_->independentRows() || others_->has(*state)) continue;
    const bool meets = std::any_of(contacts_.begin(), contacts_.end(), [&](const ForceField* field) {
      const std::vector<State*> met = field->states();
      return std::find(met.begin(), met.end(), state) != met.end();
    });
    if (meets && named) markBoundary(*state, kept);  // surfaces that meet are surfaces that move
    if (named) {
      for (const Index node : checkedNodes(choice.kept, *state, "surfaceIndices")) kept[state->firstRow() + node] = 1;
    } else {
      markBoundary(*state, kept);
    }
    std::vector<Index> watched;
    for (const Observer* observer : observers) observer->addWatchedNodes(*state, watched);
    for (const Index node : watched) kept[state->firstRow() + node] = 1;
  }
  for (std::size_t row = 0; row < kept.size(); ++row) kept[row] |= moving_[row];
  if (!named) keepFewTimedRows(kept);
  return kept;
}

/// A few inside nodes with loads that change are cheaper kept than reduced in each step.
void CondensedBody::keepFewTimedRows(std::vector<char>& kept) const {
  std::vector<Index> rows;
  for (const ForceField* field : timed_)
    if (const auto* local = dynamic_cast<const LocalLoad*>(field)) local->addLoadedRows(rows);
  std::erase_if(rows, [&](Index row) { return kept[row] != 0; });
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  const auto surface = std::count(kept.begin(), kept.end(), 1);
  if (20 * std::ptrdiff_t(rows.size()) > surface) return;
  for (const Index row : rows) kept[row] = 1;
}

void CondensedBody::renumber(const std::vector<Index>& order) {
  const std::vector<Index> old = rows_;
  for (std::size_t node = 0; node < old.size(); ++node) {
    rows_[node] = old[order[node]];
    node_of_row_[rows_[node]] = Index(node);
  }
  findTimedNodes();
}

// ---- the matrix ----

BlockMatrix CondensedBody::stiffness() const {
  BlockPattern whole_pattern(system_->allRows());
  for (const ForceField* field : stiff_) field->addPattern(whole_pattern);
  BlockMatrix whole(std::move(whole_pattern));
  for (ForceField* field : stiff_) {
    field->prepareAssembly(whole);
    field->addStiffness(-1, whole);
  }
  return whole;
}

// K by its products with two vectors of scattered numbers: a hundredth of the time of an assembly, and another K has
// the same products only where it differs by round-off.
void CondensedBody::addTo(ContentKey& key) const {
  Vector scattered(system_->allRows()), product(system_->allRows());
  std::uint64_t state = 1;
  for (int probe = 0; probe < 2; ++probe) {
    for (Index i = 0; i < scattered.count(); ++i)
      for (int c = 0; c < 3; ++c) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;  // Knuth's generator
        scattered[i][c] = 1 + std::ldexp(double(state >> 11), -53);
      }
    clear(product);
    for (const ForceField* field : stiff_) field->addStiffnessProduct(scattered, 1, product);
    key.add(product.rows().data, product.rows().doubles() * sizeof(double));
  }
  key.add(rows_);
  for (const NodeProjector& held : held_) {
    key.add(double(held.row));
    key.add(held.projector.data(), sizeof held.projector);
  }
}

BlockMatrix CondensedBody::matrix(const BlockMatrix& whole, const std::vector<double>& shift) const {
  BlockPattern pattern(free());
  const auto forEachBlock = [&](auto&& visit) {
    for (Index node = 0; node < free(); ++node)
      for (Index s = whole.rowStart()[row(node)]; s < whole.rowStart()[row(node) + 1]; ++s)
        if (const Index other = nodeOf(whole.columns()[s]); other >= 0) visit(node, other, s);
  };
  forEachBlock([&](Index node, Index other, Index) { pattern.addBlock(node, other); });
  BlockMatrix result(std::move(pattern));
  forEachBlock([&](Index node, Index other, Index s) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(whole.values().data() +
                                                                               std::size_t(s) * 9);
    result.add(node, other, Mat3(block));
  });
  for (std::size_t node = 0; node < shift.size(); ++node)
    result.add(result.diagonal()[node], Mat3(shift[node] * Mat3::Identity()));
  for (const NodeProjector& held : held_) {
    const Index node = nodeOf(held.row);
    if (node < 0) continue;
    using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    const Index diagonal = result.diagonal()[node];
    const double size = Block(result.values().data() + std::size_t(diagonal) * 9).trace() / 3;
    for (Index s = result.rowStart()[node]; s < result.rowStart()[node + 1]; ++s) {
      const Index mirrored = result.slot(result.columns()[s], node);
      Block here(result.values().data() + std::size_t(s) * 9),
          there(result.values().data() + std::size_t(mirrored) * 9);
      here = (held.projector * here).eval();
      there = (there * held.projector).eval();
    }
    result.add(diagonal, Mat3(size * (Mat3::Identity() - held.projector)));
  }
  return result;
}

std::vector<double> CondensedBody::masses() const {
  std::vector<double> all(std::size_t(system_->allRows()), 0.0), result;
  for (const Mass* mass : system_->masses())
    for (std::size_t i = 0; i < mass->lumped().size(); ++i) all[(mass->state().firstRow()) + i] += mass->lumped()[i];
  for (const Index row : rows_) result.push_back(all[row]);
  return result;
}

/// Of several masses of a node the mean of their rates, by mass.
std::vector<double> CondensedBody::massDamping() const {
  std::vector<double> all(std::size_t(system_->allRows()), 0.0), weights = all, result;
  for (const Mass* mass : system_->masses())
    for (std::size_t i = 0; i < mass->lumped().size(); ++i) {
      const std::size_t row = std::size_t(mass->state().firstRow()) + i;
      weights[row] += mass->lumped()[i];
      if (mass->lumped()[i] > 0) all[row] += (mass->rayleigh_mass - all[row]) * (mass->lumped()[i] / weights[row]);
    }
  for (const Index row : rows_) result.push_back(all[row]);
  return result;
}

// ---- loads ----

void CondensedBody::project(Vector& force) const {
  for (const NodeProjector& held : held_) force[held.row] = (held.projector * force[held.row]).eval();
}

void CondensedBody::projectNodes(Index first, double* vector) const {
  for (const NodeProjector& held : held_)
    if (const Index node = nodeOf(held.row) - first; node >= 0) {
      Eigen::Map<Vec3> value(vector + 3 * node);
      value = (held.projector * value).eval();
    }
}

std::vector<double> CondensedBody::constantForce() {
  Vector force(system_->allRows());
  for (const Mass* mass : system_->masses())
    if (!mass->node().gravity().isZero(0)) mass->addGravity(force);
  for (ForceField* field : constant_)
    field->addForce(std::count(dead_.begin(), dead_.end(), field) ? rest_ : reference_, still_, force);
  project(force);
  std::vector<double> result;
  for (const Index row : rows_)
    for (int c = 0; c < 3; ++c) result.push_back(force[row][c]);
  return result;
}

void CondensedBody::findTimedNodes() {
  timed_rows_.clear(), timed_nodes_.clear();
  for (const ForceField* field : timed_) {
    if (const auto* local = dynamic_cast<const LocalLoad*>(field)) {
      local->addLoadedRows(timed_rows_);
      continue;
    }
    for (const State* state : field->states())
      for (Index i = 0; i < state->size(); ++i) timed_rows_.push_back(state->firstRow() + i);
  }
  std::sort(timed_rows_.begin(), timed_rows_.end());
  timed_rows_.erase(std::unique(timed_rows_.begin(), timed_rows_.end()), timed_rows_.end());
  for (const Index row : timed_rows_)
    if (const Index node = nodeOf(row); node >= 0) timed_nodes_.push_back(node);
  std::sort(timed_nodes_.begin(), timed_nodes_.end());
}

void CondensedBody::updateTimedForces() {
  for (const Index row : timed_rows_) timed_force_[row].setZero();
  for (ForceField* field : timed_)
    field->addForce(std::count(dead_.begin(), dead_.end(), field) ? rest_ : reference_, still_, timed_force_);
  if (!held_.empty())
    for (const Index node : timed_nodes_) timed_force_[row(node)] = (projector(node) * timed_force_[row(node)]).eval();
}

}  // namespace stroma
