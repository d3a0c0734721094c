// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/lagrangian/actuator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/scene/archive.h"

namespace stroma::lagrangian {

void Actuator::declareValue(DataTable& table, const char* way, const char* force, bool way_first, const std::string& help) {
  way_word_ = way, force_word_ = force;
  force_is_ = way_first ? Imposed::second : Imposed::first;
  table.add("value", values_).atOnce().help(help + "; of several the one of valueIndex");
  table.add("valueIndex", index_).help("which of value").min(0);
  table.add("keyTimes", key_times_)
      .help("times, ascending, at which value has its numbers, one for each; linear between, constant before the first and after the last")
      .unit("s");
  table.add("impulses", impulses_).help(fmt::format("the {} and its bounds are those of a whole step, times dt, as in SoftRobots", force));
  std::vector<std::string> words{way, force};
  if (!way_first) std::swap(words[0], words[1]);
  table.addChoice("valueType", imposed_, words).recompiled().help("what value is");
}

double Actuator::written(const char* attribute, double value, double otherwise) const {
  return data().find(attribute)->isSet() ? value : otherwise;
}

double Actuator::Bounds::within(double value, double before) const {
  return std::clamp(std::clamp(value, before - change, before + change), least, most);
}

void Actuator::init() {
  PairConstraint::init();
  if (index_ > 0 && index_ >= int(values_.size()))
    throw ComponentError(fmt::format("valueIndex is {}, and value has {} numbers", index_, values_.size()),
                         fmt::format("0 to {}", std::max<int>(0, int(values_.size()) - 1)));
  takeKeyTimes();
}

void Actuator::takeKeyTimes() {
  keys_ = {};
  if (key_times_.empty()) return;
  if (data().find("valueIndex")->isSet()) throw ComponentError("keyTimes and valueIndex are given together", "one of them");
  if (was_keyed_ && values_.size() == 1) return;  // set by a run, and read again because something else has changed
  keys_.assign(key_times_, values_, "keyTimes", "value");
  keys_.check();
  was_keyed_ = true;
}

void Actuator::bound(const Bounds& way, const Bounds& force) {
  for (const auto& [bounds, word] : {std::pair(way, way_word_), std::pair(force, force_word_)})
    if (!(bounds.least <= bounds.most))
      throw ComponentError(fmt::format("the least {} is {:g} and the largest {:g}", word, bounds.least, bounds.most),
                           "the least below the largest");
  way_bounds_ = way, force_bounds_ = force;
}

double Actuator::value() const {
  if (values_.empty()) return 0;
  if (isKeyed()) return keys_.at(time_);
  return values_[std::min(std::size_t(index_), values_.size() - 1)];
}

double Actuator::largestValue() const {
  double largest = std::abs(value());
  for (std::size_t i = 0; isKeyed() && i < values_.size(); ++i) largest = std::max(largest, std::abs(values_[i]));
  return largest;
}

void Actuator::constrainedStepBegins(ConstRows x, double t_end) {
  time_ = t_end;
  if (!key_times_.empty() && values_.size() != 1) {  // a run may have changed them
    keys_.assign(key_times_, values_, "keyTimes", path() + ".value");
    keys_.check();
  }
  if (!is_measured_) startAt(measureAtStart(x));
  plan();
}

/// Rows of the conditions above. A force between two bounds is the one bound, given, and a push that has the way between
/// them at most.
void Actuator::plan() {
  plan_.clear();
  const double by = impulses_ ? 1 / node().root().dt() : 1;
  const Bounds force_bounds = force_bounds_.times(by);
  if (imposesForce()) {
    plan_.push_back({Kind::given, 1, 0, force_bounds.within(by * value(), force_)});
    if (way_bounds_.most < infinity) plan_.push_back({Kind::push, -1, way_bounds_.most, 0});
    if (way_bounds_.least > -infinity) plan_.push_back({Kind::push, 1, way_bounds_.least, 0});
    return;
  }
  const double at = way_bounds_.within(value(), way_), least = force_bounds.least, most = force_bounds.most;
  const bool has_least = least > -infinity, has_most = most < infinity;
  if (!has_least && !has_most) return plan_.push_back({Kind::equal, 1, at, 0});
  const double given = has_least ? least : most;
  if (given != 0 || least == most) plan_.push_back({Kind::given, 1, at, given});
  if (least == most) return;
  if (has_least)
    plan_.push_back({Kind::push, 1, at, has_most ? most - least : 0});
  else
    plan_.push_back({Kind::push, -1, at, 0});
}

void Actuator::addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const {
  now_ = measure(x);
  addPlanned(now_ - start_, rows, [&](double sign) { addGradient(x, sign, rows); });
}

double Actuator::plannedForce(std::span<const double> forces) const {
  double sum = 0;
  for (std::size_t i = 0; i < std::min(forces.size(), plan_.size()); ++i) sum += plan_[i].sign * forces[i];
  return sum;
}

void Actuator::tell(double force, double way, std::span<const double> forces) {
  force_ = force, way_ = way;
  told_force_ = impulses_ ? force_ * node().root().dt() : force_;
  PairConstraint::takeForces(forces);
}

void Actuator::takeForces(std::span<const double> forces) {
  const double force = plannedForce(forces);
  tell(force, now_ - start_, {&force, 1});
}

void Actuator::reset() {
  PairConstraint::reset();
  is_measured_ = false;
  way_ = force_ = told_force_ = 0;
}

void Actuator::serialize(Archive& archive) {
  PairConstraint::serialize(archive);
  archive.value("start", start_);
  archive.value("is_measured", is_measured_);
  archive.value("way", way_);
  archive.value("force", force_);
  archive.value("told_force", told_force_);
}

}  // namespace stroma::lagrangian
