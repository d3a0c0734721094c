// SPDX-License-Identifier: LGPL-2.1-or-later
// What a system says about itself: energies, the plan, and where a state stopped being finite.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "framework/mechanics/state_positions.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

// ---- energies ----

double System::kineticEnergy(ConstRows v_then) const {
  double sum = 0;
  for (const Mass* mass : masses_) sum += mass->kineticEnergy(v_then);
  return sum;
}

double System::elasticEnergy(ConstRows x_now) const {
  const ConstRows all = onAllRows(x_now, mapped_x_, true);
  double sum = 0;
  for (const ForceField* field : force_fields_) sum += field->energy(all);
  return sum;
}

double System::gravityEnergy(ConstRows x_now) const {
  if (!has_gravity_) return 0;
  const ConstRows all = onAllRows(x_now, mapped_x_, true);
  double sum = 0;
  for (const Mass* mass : masses_) sum += mass->gravityEnergy(all);
  return sum;
}

double System::potentialEnergy(ConstRows x_now) const { return elasticEnergy(x_now) + gravityEnergy(x_now); }

bool System::isConservative() const {
  for (const ForceField* field : force_fields_)
    if (!field->traits().conservative) return false;
  return true;
}

// ---- where something went wrong ----

namespace {

/// A body has burst when it is so many times its size at rest: parts of it may have parted by the smaller number, but
/// then their elements have kept their volumes.
constexpr double too_large = 1e6, burst = 100;

/// Over all coordinates: the sum is finite only where each of them is (and may overflow where each is).
struct Sizes {
  double sum = 0, largest = 0;
};

/// In sixteen chains, because one alone waits for the latency of each addition, which is 4 % of a step of 5,000
/// tetrahedra.
template <bool with_largest>
Sizes sizesOf(ConstRows rows) {
  constexpr std::size_t chains = 16;
  std::array<double, chains> sum{}, largest{};
  const double* __restrict numbers = rows.data;
  const std::size_t count = rows.doubles();
  const auto look = [&](std::size_t i, std::size_t k) {
    const double size = std::abs(numbers[i]);
    sum[k] += size;
    if (with_largest) largest[k] = size > largest[k] ? size : largest[k];
  };
  std::size_t i = 0;
  for (; i + chains <= count; i += chains) {
#pragma omp simd
    for (std::size_t k = 0; k < chains; ++k) look(i + k, k);
  }
  for (; i < count; ++i) look(i, i % chains);
  return {std::accumulate(sum.begin(), sum.end(), 0.0), *std::max_element(largest.begin(), largest.end())};
}

/// The diagonal of the box around `count` positions.
template <class Position>
double diagonal(Index count, Position&& position) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (Index i = 0; i < count; ++i) {
    const Vec3 p = position(i);
    low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

bool hasRestShape(const ForceField& field) {
  const ForceTraits traits = field.traits();
  return traits.has_rest_shape || traits.forces_balance;
}

double sizeAt(const State& state, ConstRows x) {
  return diagonal(state.size(), [&](Index i) -> Vec3 { return x[state.firstRow() + i]; });
}

/// The largest |J| of a field's elements; zero where it has none.
double largestVolumeRatio(const ForceField& field, ConstRows x) {
  const std::vector<std::string> names = field.cellFields();
  if (std::find(names.begin(), names.end(), "J") == names.end()) return 0;
  std::vector<double> ratios;
  field.cellField("J", x, ratios);
  double largest = 0;
  for (const double ratio : ratios) largest = std::max(largest, std::abs(ratio));
  return largest;
}

Index firstBadRow(ConstRows rows) {
  for (Index i = 0; i < rows.count; ++i)
    if (!rows[i].allFinite()) return i;
  return -1;
}

}  // namespace

std::string System::firstFault(ConstRows before) {
  if (!misplaced_.empty()) return misplaced_;
  const Sizes position = sizesOf<true>(x), velocity = sizesOf<false>(v);
  if (!std::isfinite(position.sum + velocity.sum)) {
    const bool x_good = firstBadRow(x) < 0;
    if (!x_good || firstBadRow(v) >= 0) return firstNonFinite(x_good);
  }
  if (burst_size_ < 0) {
    burst_size_ = std::numeric_limits<double>::infinity();
    for (const ForceField* field : force_fields_) {
      const double rest = hasRestShape(*field) ? restSize(field->state()) : 0;
      if (rest > 0) burst_size_ = std::min(burst_size_, burst * rest);
    }
  }
  // no box is larger than four times the farthest coordinate
  return 4 * position.largest <= burst_size_ ? std::string() : firstBurst(before);
}

std::string System::firstNonFinite(bool x_good) const {
  const ConstRows rows = x_good ? v.rows() : x.rows();
  const Index row = firstBadRow(rows);
  const auto value = rows[row];
  std::string text = fmt::format("{} has a {} that is not finite ({} {} {})", describeRow(row),
                                 x_good ? "velocity" : "position", value[0], value[1], value[2]);
  for (const ForceField* field : force_fields_) {
    const Index local = row - field->state().firstRow();
    if (local < 0 || local >= field->state().size()) continue;
    const std::string worst = field->worstElement(x);
    text += "; " + field->path() + " acts on it" + (worst.empty() ? "" : ", its worst element: " + worst);
  }
  return text;
}

// A small body far from the origin is looked at in every step: one pass over it must be enough.
std::string System::firstBurst(ConstRows before) const {
  const State* small = nullptr;
  for (const ForceField* field : force_fields_) {
    const State& state = field->state();
    if (&state == small || !hasRestShape(*field)) continue;
    const double now = sizeAt(state, x);
    if (!(now > burst_size_)) {
      small = &state;
      continue;
    }
    const double rest = restSize(state);
    const bool too_far = now > too_large * rest || (now > burst * rest && largestVolumeRatio(*field, x) > burst);
    if (rest > 0 && too_far && now > sizeAt(state, before))
      return fmt::format("{} has grown to {:.2g} times its size at rest; {} acts on it", state.path(), now / rest,
                         field->path());
  }
  return {};
}

std::vector<std::string> System::grownBodies() const {
  constexpr double large = 10;
  std::vector<std::string> sentences;
  std::vector<const State*> told;
  for (const ForceField* field : force_fields_) {
    const State& state = field->state();
    if (!hasRestShape(*field) || std::find(told.begin(), told.end(), &state) != told.end()) continue;
    const double rest = restSize(state), now = sizeAt(state, x);
    if (!(rest > 0 && now > large * rest)) continue;
    told.push_back(&state);
    sentences.push_back(
        fmt::format("{} is {:.2g} times its size at rest; {} acts on it", state.path(), now / rest, field->path()));
  }
  return sentences;
}

std::string System::describeRow(Index row) const {
  for (const State* state : states_)
    if (row >= state->firstRow() && row < state->firstRow() + state->size())
      return fmt::format("node {} of {}", row - state->firstRow(), state->path());
  return fmt::format("row {} of no state", row);
}

// ---- the plan ----

namespace {

std::string traitsText(const ForceTraits& traits) {
  std::string text;
  const auto say = [&text](const char* word) { text += (text.empty() ? "" : ", ") + std::string(word); };
  if (!traits.has_stiffness) {
    say("no stiffness: left out of products and matrices");
  } else {
    say(traits.constant_stiffness ? "constant stiffness: assembled once" : "stiffness changes with the shape");
    if (!traits.symmetric) say("not symmetric");
    if (!traits.exact_tangent) say("approximate tangent");
  }
  if (traits.linear) say("linear");
  if (traits.velocity_dependent) say("depends on velocity");
  if (traits.time_dependent) say("depends on time");
  if (!traits.conservative) say("not conservative");
  return text;
}

}  // namespace

std::vector<std::string> System::explain() const {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("system of {}: {} nodes in one vector, {} of them independent", integrator_.path(),
                              all_rows_, independent_rows_));
  for (const State* state : states_)
    lines.push_back(fmt::format("  state {}: {} nodes{}", state->path(), state->size(),
                                state->firstRow() < independent_rows_ ? "" : ", mapped"));
  for (const Mass* mass : masses_)
    lines.push_back(fmt::format("  mass {}: {:.6g} kg, {}", mass->path(), mass->totalMass(),
                                mass->isDiagonal() ? "diagonal" : "sparse matrix"));
  lines.push_back(has_gravity_ ? "  gravity: a constant force, computed once"
                               : "  gravity: skipped, there is no mass under a gravity");
  for (const ForceField* field : force_fields_)
    lines.push_back(fmt::format("  force {}: each evaluation; {}", field->path(), traitsText(field->traits())));
  if (force_fields_.empty()) lines.push_back("  forces: none but gravity");
  for (const ProjectiveConstraint* constraint : constraints_)
    lines.push_back(
        fmt::format("  constraint {}{}", constraint->path(),
                    constraint->endTime() < 0 ? "" : fmt::format(": until t = {} s", constraint->endTime())));
  if (!constraints_.empty())
    lines.push_back(fmt::format("  {} nodes held or guided, {}", projectors_.size(),
                                constraints_change_ ? "looked up at each step" : "looked up once"));
  for (const PositionConstraint* constraint : position_constraints_)
    lines.push_back(
        fmt::format("  position constraint {}: after each step; {}", constraint->path(), constraint->describe()));
  for (const Mapping* mapping : mappings_)
    lines.push_back(fmt::format("  mapping {}: each evaluation", mapping->path()));
  for (const Mapping* mapping : passive_mappings_)
    lines.push_back(fmt::format("  mapping {}: after each step; nothing acts on its nodes", mapping->path()));
  if (mappings_.empty() && passive_mappings_.empty()) lines.push_back("  mappings: none, skipped");
  lines.push_back(fmt::format("  integrator {}: {}", integrator_.path(), integrator_.describe()));
  if (!linear_solver_) lines.push_back("  linear solver: none");
  if (linear_solver_)
    lines.push_back(fmt::format("  linear solver {}: {}", linear_solver_->path(),
                                pattern_ready_ ? fmt::format("matrix of {} blocks of 3x3", block_count_)
                                               : std::string("no matrix is kept so far")));
  return lines;
}

void System::refuseRayleighFactors(const std::string& method) const {
  const auto refuse = [&](const Component& component, const char* attribute) {
    throw ComponentError(fmt::format("{} has no damping, and {} has {}", method, component.path(), attribute),
                         "an implicit dynamic integrator, or no damping", fmt::format("{}=\"0\"", attribute));
  };
  for (const Mass* mass : masses_)
    if (mass->rayleigh_mass != 0) refuse(*mass, "rayleighMass");
  for (const ForceField* field : force_fields_)
    if (field->rayleigh_stiffness != 0) refuse(*field, "rayleighStiffness");
}

}  // namespace stroma
