// SPDX-License-Identifier: LGPL-2.1-or-later
// What scenes give at times. SOFA's clock stands at the start of a step until the step is done, so that nodes are moved to where
// they were to be then, and forces are those of then; here both are of the step's end, and the times come a step later.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

constexpr double grace = 1e-9;  ///< of a step

/// Values, each of several numbers, at times.
struct Table {
  std::vector<double> times, values;
  std::size_t width = 0;

  Table(const std::string& at, const std::string& given) : times(writtenNumbers(at)), values(writtenNumbers(given)) {
    if (times.size() >= 2 && !values.empty() && values.size() % times.size() == 0 && std::is_sorted(times.begin(), times.end()))
      width = values.size() / times.size();
  }
  std::vector<double> at(double t) const {
    std::size_t next = 1;
    while (next + 1 < times.size() && times[next] <= t) ++next;
    const double span = times[next] - times[next - 1], share = span > 0 ? (t - times[next - 1]) / span : 1;
    std::vector<double> value;
    for (std::size_t k = 0; k < width; ++k)
      value.push_back((1 - share) * values[(next - 1) * width + k] + share * values[next * width + k]);
    return value;
  }
  void putFirst(double t, const std::vector<double>& value) {
    times.insert(times.begin(), t);
    values.insert(values.begin(), value.begin(), value.end());
  }
  void putLast(double t, const std::vector<double>& value) {
    times.push_back(t);
    values.insert(values.end(), value.begin(), value.end());
  }
  void delay(double h) {
    for (double& time : times) time += h;
  }
};

/// Ends a table where the last step ends that begins before `last`, with a value.
void cutAt(Table& table, double t, const std::vector<double>& value) {
  while (!table.times.empty() && table.times.back() > t * (1 - grace)) {
    table.times.pop_back();
    table.values.resize(table.values.size() - table.width);
  }
  table.putLast(t, value);
}

/// A movement holds its nodes in the steps that begin from its first time on and before its last one.
void delayMovement(Table& table, double h) {
  const double first = table.times.front(), last = table.times.back();
  const std::vector<double> start(table.values.begin(), table.values.begin() + std::ptrdiff_t(table.width));
  const double steps = std::ceil(last / h - grace);
  if (steps < 1) return;
  const std::vector<double> end = table.at((steps - 1) * h);
  table.delay(h);
  cutAt(table, steps * h, end);
  if (first <= 0 && table.times.front() > 0)
    table.putFirst(0, start);
  else if (first > 0)
    table.putFirst(first + h / 2, start);
}

/// SOFA adds h v of the start of each step: the integral of the same velocities half a step later, but for steps with a key inside.
void delayVelocity(Table& table, double h) {
  const double first = table.times.front(), steps = std::ceil(table.times.back() / h - grace);
  if (steps < 1 || first < 0) return;
  const std::vector<double> end = table.at((steps - 0.5) * h), start = table.at(first - h / 2), left = table.at((steps - 1) * h);
  table.delay(h / 2);
  cutAt(table, (steps - 1e-6) * h, end);
  table.putLast(steps * h, left);  // with which the nodes go on
  table.putFirst(first, start);
}

}  // namespace

/// The step of the scene: those of nodes below do not count.
double Rewriting::timeStep() const {
  const AttributeDescription* dt = scene_.root.find("dt");
  const double h = dt ? std::atof(dt->value.c_str()) : 0;
  return h > 0 ? h : 0.01;
}

/// Nodes that make a part of a movement, linear between the corners of a box; of lengths of which one is zero the others count.
void Rewriting::shareMovement(Element& constraint) {
  const AttributeDescription* shares = constraint.find("imposedDisplacmentOnMacroNodes");
  if (!shares || !saysYes(constraint.text("linearMovementBetweenNodesInIndices"))) return;
  for (const char* name : {"X0", "Y0", "Z0"})
    if (constraint.find(name) && (!constraint.writes(name) || constraint.text(name).starts_with("@"))) return;  // refused, as a link
  std::vector<double> numbers = writtenNumbers(shares->value);
  if (numbers.empty()) return;
  double a = std::atof(constraint.text("X0").c_str()), b = std::atof(constraint.text("Y0").c_str());
  const double c = std::atof(constraint.text("Z0").c_str());
  const bool is_flat = a == 0 || b == 0 || c == 0;
  if (a == 0) a = b, b = c;
  if (b == 0) b = c;
  const std::size_t count = is_flat ? 4 : 8;
  if (numbers.size() < count) {
    diagnostics_.error(shares->where, constraint.path() + "." + shares->name, "has " + std::to_string(numbers.size()) + " numbers",
                       is_flat ? "four, as one of X0, Y0 and Z0 is zero" : "eight, as none of X0, Y0 and Z0 is zero");
  } else if (!(a > 0 && b > 0 && (is_flat || c > 0))) {
    diagnostics_.error(constraint.written->where, constraint.path(), "X0, Y0 and Z0 are no size of a box",
                       "positive lengths, of which one may be zero");
  } else {
    numbers.resize(count);
    constraint.set("cornerBox", printed({a, b, is_flat ? 0 : c}));
    constraint.set("cornerShares", printed(numbers));
  }
  for (const char* name : {"linearMovementBetweenNodesInIndices", "imposedDisplacmentOnMacroNodes", "X0", "Y0", "Z0"})
    constraint.remove(name);
}

void Rewriting::meanTimes(Element& element) {
  const std::string& type = element.written->type;
  const bool moves = type == "LinearMovementProjectiveConstraint" || type == "PartialLinearMovementProjectiveConstraint";
  const bool spans = type == "AffineMovementProjectiveConstraint" || type == "PatchTestMovementProjectiveConstraint";
  const bool bends = type == "ParabolicProjectiveConstraint" || type == "HermiteSplineProjectiveConstraint";
  const bool swings = type == "OscillatorProjectiveConstraint", loads = type == "LinearForceField";
  const bool flows = type == "LinearVelocityProjectiveConstraint" && !element.find("continueAfterEnd");
  const bool turns = type == "OscillatingTorsionPressureForceField";
  if ((!moves && !spans && !bends && !turns && !swings && !loads && !flows) || !quirks_.use("late-times", element.path())) return;
  const double h = timeStep();
  if (spans) {
    for (const auto& [name, otherwise] : {std::pair("beginConstraintTime", 0.), std::pair("endConstraintTime", 20.)})
      element.set(name, printReal((element.find(name) ? std::atof(element.text(name).c_str()) : otherwise) + h));
    return;
  }
  const Element* integrator = element.place->nearest("integrator");
  const bool is_explicit = integrator && (integrator->is("EulerExplicitSolver") || integrator->is("CentralDifferenceSolver") ||
                                          integrator->written->type.starts_with("RungeKutta"));
  if (turns) {
    if (is_explicit) return;
    const double frequency = element.find("frequency") ? std::atof(element.text("frequency").c_str()) : 1;
    return element.set("phase", printReal(-2 * std::numbers::pi * frequency * h));
  }
  if (bends) {
    for (const char* name : {"BeginTime", "EndTime"}) element.set(name, printReal(std::atof(element.text(name).c_str()) + h));
    return;
  }
  if (swings) {
    const Element* state = element.place->nearest("mechanical state");
    const std::size_t width = state && state->text("template").starts_with("Rigid3") ? 16 : 9;
    std::vector<double> numbers = writtenNumbers(element.text("oscillators"));
    for (std::size_t i = width; i <= numbers.size(); i += width) numbers[i - 1] -= numbers[i - 2] * h;
    if (!numbers.empty()) element.set("oscillators", printed(numbers));
    return;
  }
  const char* at = element.find("times") ? "times" : "keyTimes";
  const char* values = moves ? "movements" : flows ? "velocities" : "forces";
  Table table(element.text(at), element.text(values));
  if (table.width == 0) return;
  if (moves) {
    delayMovement(table, h);
  } else if (flows) {
    delayVelocity(table, h);
  } else {
    const double first = table.times.front();
    if (!is_explicit) table.delay(h);
    if (first > 0) table.putFirst(table.times.front() - 1e-6 * h, std::vector<double>(table.width, 0.));  // nothing before it
  }
  element.set(at, printed(table.times));
  element.set(values, printed(table.values));
}

}  // namespace stroma::sofa
