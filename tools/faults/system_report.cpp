// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/system_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "framework/mechanics/state_positions.h"
#include "framework/simulation/integrator.h"

namespace stroma {

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
[[gnu::always_inline]] inline Sizes sizesIn(const double* __restrict numbers, std::size_t count) {
  constexpr std::size_t chains = 16;
  std::array<double, chains> sum{}, largest{};
  std::size_t i = 0;
  for (; i + chains <= count; i += chains) {
#pragma omp simd
    for (std::size_t k = 0; k < chains; ++k) {
      const double size = std::abs(numbers[i + k]);
      sum[k] += size;
      if (with_largest) largest[k] = size > largest[k] ? size : largest[k];
    }
  }
  for (; i < count; ++i) {
    sum[i % chains] += std::abs(numbers[i]);
    if (with_largest) largest[i % chains] = std::max(largest[i % chains], std::abs(numbers[i]));
  }
  return {std::accumulate(sum.begin(), sum.end(), 0.0), *std::max_element(largest.begin(), largest.end())};
}
template <bool with_largest>
Sizes sizesInNarrow(const double* numbers, std::size_t count) {
  return sizesIn<with_largest>(numbers, count);
}
/// The same with registers of four numbers, in half of the time.
template <bool with_largest>
[[gnu::target("avx2")]] Sizes sizesInWide(const double* numbers, std::size_t count) {
  return sizesIn<with_largest>(numbers, count);
}
template <bool with_largest>
Sizes sizesOf(ConstRows rows) {
  static const auto look = __builtin_cpu_supports("avx2") ? sizesInWide<with_largest> : sizesInNarrow<with_largest>;
  return look(rows.data, rows.doubles());
}

bool hasRestShape(const ForceField& field) {
  const ForceTraits traits = field.traits();
  return traits.has_rest_shape || traits.forces_balance;
}

double sizeAt(const State& state, ConstRows x) {
  const ConstRows rows = state.segment(x);
  return sizeOfBox(state, [&](Index i) -> Vec3 { return rows[i]; });
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

std::string actsOnIt(const ForceField& field, const System& system) {
  const std::string worst = worstElementOf(field, system, system.x);
  return field.path() + " acts on it" + (worst.empty() ? "" : ", its worst element: " + worst);
}

Index firstBadRow(ConstRows rows) {
  for (Index i = 0; i < rows.count; ++i)
    if (!rows[i].allFinite()) return i;
  return -1;
}

}  // namespace

std::string FaultWatch::firstFault(ConstRows before) {
  if (!system_.constraints().misplaced().empty()) return system_.constraints().misplaced();
  // the rows of mapped states that nothing acts on are the last ones, and stay as they are until someone reads them
  const auto& passive = system_.actors().passive_mappings;
  const long placings = system_.mappingChain().passivePlacings();
  const bool all = passive.empty() || placings != placings_seen_;
  const Index rows = all ? system_.allRows() : passive.front()->output().firstRow();
  const ConstRows x = system_.x.head(rows), v = system_.v.head(rows);
  const Sizes position = sizesOf<true>(x), velocity = sizesOf<false>(v);
  if (!std::isfinite(position.sum + velocity.sum) && (firstBadRow(x) >= 0 || firstBadRow(v) >= 0)) return firstNonFinite(x, v);
  placings_seen_ = placings;
  if (burst_size_ < 0) {
    burst_size_ = std::numeric_limits<double>::infinity();
    for (const ForceField* field : system_.forceFields()) {
      const double rest = hasRestShape(*field) ? restSize(field->state()) : 0;
      if (rest > 0) burst_size_ = std::min(burst_size_, burst * rest);
    }
  }
  // no box is larger than four times the farthest coordinate
  return 4 * position.largest <= burst_size_ ? std::string() : firstBurst(before);
}

std::string FaultWatch::firstNonFinite(ConstRows x, ConstRows v) const {
  const bool x_good = firstBadRow(x) < 0;
  const ConstRows rows = x_good ? v : x;
  const Index row = firstBadRow(rows);
  const auto value = rows[row];
  std::string text = fmt::format("{} has a {} that is not finite ({} {} {})", system_.actors().describeRow(row),
                                 x_good ? "velocity" : "position", value[0], value[1], value[2]);
  for (const ForceField* field : system_.forceFields()) {
    const Index local = row - field->state().firstRow();
    if (local < 0 || local >= field->state().size()) continue;
    text += "; " + actsOnIt(*field, system_);
  }
  return text;
}

// A small body far from the origin is looked at in every step: one pass over it must be enough.
std::string FaultWatch::firstBurst(ConstRows before) const {
  const State* small = nullptr;
  for (const ForceField* field : system_.forceFields()) {
    const State& state = field->state();
    if (&state == small || !hasRestShape(*field)) continue;
    const double now = sizeAt(state, system_.x);
    if (!(now > burst_size_)) {
      small = &state;
      continue;
    }
    const double rest = restSize(state);
    const bool too_far =
        now > too_large * rest || (now > burst * rest && largestVolumeRatio(*field, system_.x) > burst);
    if (rest > 0 && too_far && now > sizeAt(state, before))
      return fmt::format("{} has grown to {:.2g} times its size at rest; {}", state.path(), now / rest, actsOnIt(*field, system_));
  }
  return {};
}

std::vector<std::string> grownBodies(const System& system) {
  constexpr double large = 10;
  std::vector<std::string> sentences;
  std::vector<const State*> told;
  for (const ForceField* field : system.forceFields()) {
    const State& state = field->state();
    if (!hasRestShape(*field) || std::find(told.begin(), told.end(), &state) != told.end()) continue;
    const double rest = restSize(state), now = sizeAt(state, system.x);
    if (!(rest > 0 && now > large * rest)) continue;
    told.push_back(&state);
    sentences.push_back(
        fmt::format("{} is {:.2g} times its size at rest; {} acts on it", state.path(), now / rest, field->path()));
  }
  return sentences;
}

void refuseRayleighFactors(const System& system, const std::string& method) {
  const auto refuse = [&](const Component& component, const char* attribute) {
    throw ComponentError(fmt::format("{} has no damping, and {} has {}", method, component.path(), attribute),
                         "an implicit dynamic integrator, or no damping", fmt::format("{}=\"0\"", attribute));
  };
  for (const Mass* mass : system.masses())
    if (mass->rayleigh_mass != 0) refuse(*mass, "rayleighMass");
  for (const ForceField* field : system.forceFields())
    if (field->rayleigh_stiffness != 0) refuse(*field, "rayleighStiffness");
}

}  // namespace stroma
