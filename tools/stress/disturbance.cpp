// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/disturbance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"

namespace stroma::stress {
namespace {

/// The same numbers on every machine: distributions of the library are not.
class Chance {
 public:
  explicit Chance(unsigned seed) : engine_(seed) {}
  double share() { return double(engine_()) / 4294967296.; }
  double sign() { return 2 * share() - 1; }
  std::size_t below(std::size_t count) { return engine_() % count; }
  Vec3 vector() {
    const double a = sign(), b = sign(), c = sign();
    return {a, b, c};
  }

 private:
  std::mt19937 engine_;
};

using Box = Eigen::AlignedBox3d;

Box boxOf(const State& state) {
  Box box;
  for (Index i = 0; i < state.size(); ++i)
    if (state.kindOf(i) == RowKind::place) box.extend(Vec3(state.x()[i]));
  return box;
}

double extent(const Box& box) {
  const double diagonal = box.isEmpty() ? 0 : box.diagonal().norm();
  return diagonal > 0 && std::isfinite(diagonal) ? diagonal : 1;
}

bool isFree(const System& system, Index row) {
  const Index held = system.constraints().projectorOf(row);
  return held < 0 || !system.constraints().projectors()[std::size_t(held)].projector.isZero();
}

/// Changes of the free directions of a row.
Vec3 freePart(const System& system, Index row, const Vec3& change) {
  const Index held = system.constraints().projectorOf(row);
  return held < 0 ? change : Vec3(system.constraints().projectors()[std::size_t(held)].projector * change);
}

/// Where a node at p goes.
Vec3 placed(Shape shape, double amount, const Vec3& p, const Box& box, int axis, Chance& chance) {
  const Vec3 centre = box.center(), from = p - centre;
  const double size = extent(box);
  Vec3 to = p;
  switch (shape) {
    case Shape::small:
      return p + amount * size * chance.vector();
    case Shape::pulled:
      return p + amount * size * Vec3(std::sin(7 * from[1] / size), from[2] / size, std::cos(5 * from[0] / size)) +
             0.1 * amount * size * chance.vector();
    case Shape::mirrored:
      to[axis] = centre[axis] - from[axis];
      return to + 1e-6 * size * chance.vector();  // an exact mirror image may balance
    case Shape::flat:
      to[axis] = centre[axis];
      return to;
    case Shape::line:
      to = centre;
      to[axis] = p[axis];
      return to;
    case Shape::point:
      return centre + amount * from;
    case Shape::random:
      return centre + amount * 0.5 * box.sizes().cwiseProduct(chance.vector());
    case Shape::stretched:
      return centre + amount * from;
    default:
      return p;
  }
}

struct ChosenCell {
  Index row = -1;  ///< of the system, of the corner that moves
  Vec3 to = Vec3::Zero();
};

/// A corner of a volume cell that is free, and its mirror image in the middle of the others.
template <class Cell>
ChosenCell corner(const System& system, const State& state, const Cell& cell, std::size_t first) {
  for (std::size_t k = 0; k < cell.size(); ++k) {
    const std::size_t moved = (first + k) % cell.size();
    const Index row = state.firstRow() + Index(cell[moved]);
    if (!isFree(system, row)) continue;
    Vec3 others = Vec3::Zero();
    for (std::size_t a = 0; a < cell.size(); ++a)
      if (a != moved) others += Vec3(system.x[state.firstRow() + Index(cell[a])]);
    return {row, 2 * others / double(cell.size() - 1) - Vec3(system.x[row])};
  }
  return {};
}

ChosenCell chooseCell(const System& system, const State& state, Chance& chance) {
  ChosenCell chosen;
  for (const Topology* topology : topologiesOf(state))
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          if (kind.dimension < 3 || cells.empty() || chosen.row >= 0) return;
          const std::size_t start = chance.below(cells.size()), first = chance.below(std::size_t(kind.nodes));
          for (std::size_t c = 0; c < cells.size() && chosen.row < 0; ++c)
            chosen = corner(system, state, cells[(start + c) % cells.size()], first);
        },
        topology->mesh());
  return chosen;
}

bool disturbState(System& system, const State& state, Shape shape, double amount, Chance& chance, double dt) {
  if (shape == Shape::cell) {
    const ChosenCell chosen = chooseCell(system, state, chance);
    if (chosen.row < 0) return false;
    const Vec3 change = freePart(system, chosen.row, amount * (chosen.to - Vec3(system.x[chosen.row])));
    system.x[chosen.row] += change;
    return true;
  }
  const Box box = boxOf(state);
  const int axis = int(chance.below(3));
  bool moved = false;
  for (Index i = 0; i < state.size(); ++i) {
    const Index row = state.firstRow() + i;
    if (state.kindOf(i) != RowKind::place || !isFree(system, row)) continue;
    moved = true;
    if (shape == Shape::kicked) {
      system.v[row] += freePart(system, row, amount * extent(box) / dt * chance.vector());
    } else {
      const Vec3 p = system.x[row];
      system.x[row] += freePart(system, row, placed(shape, amount, p, box, axis, chance) - p);
    }
  }
  return moved;
}

bool isHeldPlace(const System& system, const NodeProjector& held) {
  return held.row < system.independentRows() && system.motion().kindOf(held.row) == RowKind::place;
}

bool hasFreePlace(const System& system, const State& state) {
  for (Index i = 0; i < state.size(); ++i)
    if (state.kindOf(i) == RowKind::place && isFree(system, state.firstRow() + i)) return true;
  return false;
}

}  // namespace

Reach reachOf(const Simulation& simulation) {
  Reach reach;
  Chance any(1);
  for (const auto& system : simulation.systems()) {
    if (system->integrator().stateOwner()) continue;
    for (const State* state : system->states()) {
      if (state->firstRow() >= system->independentRows()) continue;
      reach.places = reach.places || hasFreePlace(*system, *state);
      reach.corners = reach.corners || chooseCell(*system, *state, any).row >= 0;
    }
    for (const NodeProjector& held : system->constraints().projectors())
      reach.held = reach.held || isHeldPlace(*system, held);
  }
  return reach;
}

double sizeOf(const System& system) {
  double size = 0;
  for (const State* state : system.states()) {
    Box box;
    for (Index i = 0; i < state->size(); ++i)
      if (state->kindOf(i) == RowKind::place) box.extend(state->rest_position[std::size_t(i)]);
    if (!box.isEmpty()) size = std::max(size, box.diagonal().norm());
  }
  return size > 0 ? size : 1;
}

bool disturb(const Simulation& simulation, Shape shape, double amount, unsigned seed) {
  Chance chance(seed);
  bool moved = false;
  for (const auto& system : simulation.systems()) {
    if (system->integrator().stateOwner()) continue;
    bool here = false;
    for (const State* state : system->states())
      if (state->firstRow() < system->independentRows())
        here = disturbState(*system, *state, shape, amount, chance, simulation.dt()) || here;
    if (here) system->applyMappings();
    moved = moved || here;
  }
  return moved;
}

bool moveHeld(const Simulation& simulation, double amount, unsigned seed) {
  Chance chance(seed);
  const Vec3 way = chance.vector().normalized();
  bool moved = false;
  for (const auto& system : simulation.systems()) {
    if (system->integrator().stateOwner()) continue;
    const double size = sizeOf(*system);
    for (const NodeProjector& held : system->constraints().projectors()) {
      if (!isHeldPlace(*system, held)) continue;
      system->x[held.row] += Vec3(amount * size * (way - held.projector * way));
      moved = true;
    }
    system->applyMappings();
  }
  return moved;
}

FreeRow freeRow(const Simulation& simulation, unsigned seed) {
  Chance chance(seed);
  std::vector<FreeRow> free;
  for (const auto& system : simulation.systems())
    for (Index row = 0; row < system->independentRows() && !system->integrator().stateOwner(); ++row)
      if (system->motion().kindOf(row) == RowKind::place && isFree(*system, row)) free.push_back({system.get(), row});
  return free.empty() ? FreeRow{} : free[chance.below(free.size())];
}

}  // namespace stroma::stress
