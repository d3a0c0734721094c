// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tools/stress/disturbance.h"

namespace stroma::stress {
namespace {

/// The decades of the rounds; nothing is likelier to be met than a factor of ten or a thousand.
constexpr double rounds[] = {3, -3, 1, -1, 6, -6};
constexpr double ratio_rounds[] = {2, 1, 4, 3, 6, 7};
constexpr int thread_counts[] = {2, 5, 16, 64};
constexpr double memory_rounds[] = {0.25, 1, 4, 32};  // MB beyond what the process has

/// Whether there is more and less of it.
bool hasAmount(const Case& one) {
  return one.shape != Shape::mirrored && one.shape != Shape::flat && one.shape != Shape::line && one.amount != 0;
}

Case shapeCase(Shape shape, double amount, const char* group, const std::string& text) {
  return {.kind = Kind::shape, .group = group, .text = text, .shape = shape, .amount = amount};
}

/// The value of a target in a round, and what that is in words. Empty when it is the present one.
std::pair<std::string, std::string> valueIn(const Target& target, double decades, double ratio_decades, bool above) {
  if (target.quantity == Quantity::ratio) {
    const std::string value = target.nearEnd(ratio_decades, above);
    return {value, fmt::format("{} = {}", target.name(), value)};
  }
  const std::string value = target.scaled(decades);
  return {value, fmt::format("{} x 1e{:+.3g} = {}", target.name(), decades, value)};
}

/// The same, elsewhere and more or less of it.
Case atRandom(Case one, double decades) {
  one.text += hasAmount(one) ? fmt::format(" (times {:.4g})", std::pow(10, decades)) : " (by another seed)";
  if (hasAmount(one)) one.amount *= std::pow(10, decades);
  return one;
}

std::string groupOf(const Target& target) {
  return target.path == "/" && target.attribute == "dt" ? "dt" : wordOf(target.quantity);
}

}  // namespace

CaseList::CaseList(const Simulation& simulation, unsigned seed) : seed_(seed), targets_(targetsOf(simulation)) {
  const Reach reach = reachOf(simulation);
  addForces(reach);
  if (reach.places) addShapes(reach);
  if (reach.held) addMoves();
  addEntries(simulation, reach);
  for (std::size_t round = 0; round < std::size(rounds); ++round) {
    addAttributes(round);
    if (round < std::size(thread_counts))
      add({.kind = Kind::threads,
           .group = "threads",
           .text = fmt::format("{} threads", thread_counts[round]),
           .amount = double(thread_counts[round])});
    if (round < std::size(memory_rounds))
      add({.kind = Kind::memory,
           .group = "memory",
           .text = fmt::format("{} MB more than the command alone", memory_rounds[round]),
           .amount = memory_rounds[round]});
  }
}

void CaseList::add(Case one) {
  one.number = long(cases_.size()) + 1;
  one.seed = seed_ + unsigned(one.number) * 7919u;
  cases_.push_back(std::move(one));
}

void CaseList::addForces(const Reach& reach) {
  const std::pair<Shape, const char*> shapes[] = {{Shape::small, "near the start"},
                                                  {Shape::pulled, "of a pulled body"},
                                                  {Shape::cell, "with a cell inside out"},
                                                  {Shape::mirrored, "of a mirrored body"}};
  for (const auto& [shape, words] : shapes) {
    if (shape == Shape::cell ? !reach.corners : shape != Shape::small && !reach.places) continue;
    add({.kind = Kind::forces,
         .group = "forces and derivatives",
         .text = fmt::format("forces, energies and derivatives {}", words),
         .shape = shape,
         .amount = shape == Shape::small ? 1e-4 : shape == Shape::pulled ? 0.05 : 1});
  }
}
void CaseList::addShapes(const Reach& reach) {
  for (const double amount : {0.01, 0.05})
    add(shapeCase(Shape::pulled, amount, "pulled", fmt::format("nodes pulled by {} of the size", amount)));
  if (reach.corners)
    for (int k = 0; k < 3; ++k) add(shapeCase(Shape::cell, 1, "inverted", "one corner of a cell through its others"));
  add(shapeCase(Shape::mirrored, 1, "inverted", "free nodes mirrored"));
  add(shapeCase(Shape::flat, 1, "flat", "free nodes in a plane"));
  add(shapeCase(Shape::line, 1, "flat", "free nodes on a line"));
  add(shapeCase(Shape::point, 0.1, "crushed", "free nodes at a tenth of their distance from the centre"));
  add(shapeCase(Shape::point, 0, "crushed", "free nodes in one point"));
  add(shapeCase(Shape::random, 1, "at random", "free nodes at random places of the body's box"));
  add(shapeCase(Shape::stretched, 3, "stretched", "free nodes three times as far apart"));
  add(shapeCase(Shape::kicked, 0.1, "kicked", "velocities of a tenth of the size in a step"));
}

void CaseList::addMoves() {
  for (const double amount : {0.1, 1.})
    add({.kind = Kind::move,
         .group = "sudden moves",
         .text = fmt::format("fixed nodes jump by {} of the size, and back", amount),
         .amount = amount});
}

void CaseList::addEntries(const Simulation& simulation, const Reach& reach) {
  const auto entry = [&](Entry kind, const std::string& text) {
    return Case{.kind = Kind::not_finite, .group = "NaN", .text = text, .entry = kind};
  };
  if (reach.places) {
    add(entry(Entry::position, "a position becomes NaN between two steps"));
    add(entry(Entry::velocity, "a velocity becomes NaN between two steps"));
  }
  if (!simulation.states().empty()) add(entry(Entry::force, "a force from outside is NaN"));
  add(entry(Entry::edit, "dt becomes NaN while the scene runs"));
  bool infinite = false;  // in turn
  for (const Target& target : targets_) {
    Case one = entry(infinite ? Entry::infinite_attribute : Entry::attribute,
                     fmt::format("{} = {}", target.name(), infinite ? "1e999" : "nan"));
    one.override = Override{target.path, target.attribute, infinite ? "1e999" : "nan"};
    add(one);
    infinite = !infinite;
  }
}

void CaseList::addAttributes(std::size_t round) {
  for (const Target& target : targets_) {
    const auto [value, text] = valueIn(target, rounds[round], ratio_rounds[round], round % 2 == 0);
    const Override override{target.path, target.attribute, value};
    const bool is_known = std::any_of(cases_.begin(), cases_.end(), [&](const Case& other) {
      return other.override && other.override->path == override.path &&
             other.override->attribute == override.attribute && other.override->value == value;
    });
    if (value.empty() || is_known) continue;
    add({.kind = Kind::attribute, .group = groupOf(target), .text = text, .override = override});
  }
}

Case CaseList::at(long number) const {
  if (number <= size()) return cases_[std::size_t(number - 1)];
  std::mt19937 random(seed_ + unsigned(number) * 104729u);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967295.; };
  Case one;
  std::string value;
  for (int tries = 0; tries < 20 && value.empty() && random() % 3 != 0; ++tries) {
    const Target& target = targets_[random() % targets_.size()];
    const double decades = uniform(-9, 9), ratio_decades = uniform(0.5, 9);
    const auto [changed, text] = valueIn(target, decades, ratio_decades, random() % 2 == 0);
    value = changed;  // empty where the number is at the end of its range, or zero
    one = {.kind = Kind::attribute,
           .group = groupOf(target),
           .text = text,
           .override = Override{target.path, target.attribute, value}};
  }
  if (value.empty()) {
    std::vector<const Case*> shapes;
    for (const Case& other : cases_)
      if (other.kind == Kind::shape || other.kind == Kind::move || other.kind == Kind::forces) shapes.push_back(&other);
    const Case& other = *shapes[random() % shapes.size()];
    one = atRandom(other, uniform(-1, 0.5));
  }
  one.number = number;
  one.seed = seed_ + unsigned(number) * 7919u;
  return one;
}

}  // namespace stroma::stress
