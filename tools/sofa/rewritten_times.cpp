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

/// A factor of the forces before the last time: from then on SOFA's are those of the table.
void scaleForces(Element& load) {
  const char* name = load.find("times") ? "times" : "keyTimes";
  std::vector<double> forces = writtenNumbers(load.text("forces")), times = writtenNumbers(load.text(name));
  if (times.size() < 2 || forces.empty() || forces.size() % times.size() != 0) return;
  const std::vector<double> last(forces.end() - std::ptrdiff_t(forces.size() / times.size()), forces.end());
  for (double& force : forces) force *= std::atof(load.text("force").c_str());
  constexpr double instant = 1e-9;  // of the last stretch
  const double end = times.back();
  times.back() -= instant * (end - times[times.size() - 2]);
  times.push_back(end), forces.insert(forces.end(), last.begin(), last.end());
  load.set(name, printed(times)), load.set("forces", printed(forces));
  load.remove("force");
}

/// A number for all, which counts, or a vector for each node or for all.
void nameCoefficients(Element& damping, bool of_frames) {
  const char* vector = "dampingCoefficientVector";
  if (damping.find("dampingCoefficient")) {
    const double number = std::atof(damping.text("dampingCoefficient").c_str());
    damping.set("dampingCoefficient", printed(std::vector<double>(of_frames ? 6 : 3, number)));
  } else if (const AttributeDescription* given = damping.find(vector)) {
    AttributeDescription renamed = *given;
    renamed.name = "dampingCoefficient";
    damping.written->attributes.push_back(std::move(renamed));
  }
  damping.remove(vector);
}

/// SOFA's pulse goes on in each evaluation of the force, one in a step, by as much as the pressure changes in a step.
void Rewriting::meanPulse(Element& pressure) {
  if (!saysYes(pressure.text("pulseMode"))) {
    for (const char* of_pulse : {"pressureLowerBound", "pressureSpeed"}) pressure.remove(of_pulse);
    return;
  }
  const std::string speed = pressure.text("pressureSpeed"), end = pressure.text("pressure");
  const bool is_link = speed.starts_with('@'), has_end = end.starts_with('@') || std::atof(end.c_str()) != 0;
  if (!is_link && (std::atof(speed.c_str()) < 0 || (std::atof(speed.c_str()) == 0 && !has_end))) {
    pressure.dropped = true;
    return warn(pressure.written->where, pressure, "pressureSpeed", "is not above zero: SOFA's pulse stays at zero");
  }
  if (!is_link && std::atof(speed.c_str()) == 0) pressure.remove("pressureSpeed");  // SOFA's is then |pressure|, and so is the default
  const Element* integrator = pressure.place->nearest("integrator");
  const bool at_start = integrator && isAnyOf(integrator->written->type, {"EulerExplicitSolver", "CentralDifferenceSolver"});
  setDefault(pressure, "pulseSteps", at_start ? "start" : "end");
}

/// The step of the scene: those of nodes below do not count.
double Rewriting::timeStep() const {
  const AttributeDescription* dt = scene_.root.find("dt");
  const double h = dt ? std::atof(dt->value.c_str()) : 0;
  return h > 0 ? h : 0.01;
}

/// Forces of a state, which SOFA forgets after the first step: a force on each node that ends then. (Within a step it would not do:
/// integrators that ask inside of one keep what is refused.)
void Rewriting::takeExternalForces() {
  std::vector<Element*> states;
  tree_->forEach([&states](Element& element) {
    if (element.is("MechanicalObject") && element.writes("externalForce")) states.push_back(&element);
  });
  for (Element* state : states) {
    const std::string text = state->text("externalForce"), kind = state->text("template");
    const std::vector<double> numbers = writtenNumbers(text);
    const Element* integrator = state->place->nearest("integrator");
    const std::size_t width = kind.starts_with("Rigid3") ? 6 : 3;
    const bool is_known = kind.empty() || kind.starts_with("Vec3") || width == 6;
    if (text.find('@') != std::string::npos || !is_known || !integrator || numbers.size() % width != 0 ||
        integrator->written->type.starts_with("RungeKutta"))
      continue;
    const double h = timeStep();
    const std::string times = printed({0, h / 2, 3 * h / 4});
    for (std::size_t node = 0; node < numbers.size() / width; ++node) {
      const auto first = numbers.begin() + std::ptrdiff_t(node * width);
      const std::vector<double> force(first, first + std::ptrdiff_t(width)), none(width, 0);
      if (force == none) continue;
      const SourceLocation where = state->find("externalForce")->where;
      tree_->add(*state->place, {"LinearForceField",
                                 {{"name", state->name + "_force_" + std::to_string(node), where},
                                  {"mstate", SceneTree::linkTo(*state), where},
                                  {"points", std::to_string(node), where},
                                  {"times", times, where},
                                  {"forces", printed(force) + " " + printed(force) + " " + printed(none), where}},
                                 where, state->written->folder});
    }
    state->remove("externalForce");
  }
}

/// SOFA's turns are Euler angles about the axes of a frame, those here rotation vectors in fixed axes: the same about one axis of a
/// frame that starts unturned.
void Rewriting::warnOfTurns(const Element& movement) {
  const Element* state = movement.place->nearest("mechanical state");
  if (!state || !state->text("template").starts_with("Rigid3")) return;
  const std::vector<double> numbers = writtenNumbers(movement.text("movements")), places = writtenNumbers(state->text("position"));
  constexpr std::size_t width = 6, frame = 7;
  bool turns[3] = {false, false, false}, is_turned = state->text("position").find('@') != std::string::npos;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (i % width >= 3 && numbers[i] != 0) turns[i % width - 3] = true;
  for (std::size_t i = 0; i < places.size(); ++i) is_turned = is_turned || (i % frame >= 3 && i % frame < 6 && places[i] != 0);
  const int axes = turns[0] + turns[1] + turns[2];
  if (axes > 1 || (axes == 1 && is_turned))
    warn(movement.written->where, movement, "movements",
         "turns frames by rotation vectors in fixed axes: in SOFA these are Euler angles about the axes of the frame");
}

/// Nodes that no integrator moves stay where they are along the other axes: there is no velocity that would take them along.
static void clearOtherAxes(Element& movement) {
  const auto& here = movement.place->elements;
  const bool is_held = std::any_of(here.begin(), here.end(), [](const auto& each) { return each->name.starts_with("held_by_the_scene_"); });
  const std::vector<double> moved = writtenNumbers(movement.text("movedDirections"));
  std::vector<double> numbers = writtenNumbers(movement.text("movements"));
  if (!is_held || moved.empty() || numbers.empty()) return;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (moved[i % moved.size()] == 0) numbers[i] = 0;
  movement.set("movements", printed(numbers));
}

/// Along axes that are not driven SOFA's nodes keep the velocity that they have, whatever pulls at them.
void Rewriting::holdOtherAxes(Element& flow) {
  const std::vector<double> driven = writtenNumbers(flow.text("coordinates")), times = writtenNumbers(flow.text("keyTimes"));
  const Element* state = flow.place->nearest("mechanical state");
  const bool is_of_points = !state || state->text("template").empty() || state->text("template").starts_with("Vec3");
  if (driven.empty() || !is_of_points || times.empty()) return;
  if (times.front() > 0)
    return warn(flow.written->where, flow, "coordinates", "leaves the other axes free: SOFA holds them from the first key time on");
  bool still[3] = {true, true, true};
  for (const double axis : driven)
    if (axis >= 0 && axis < 3) still[std::size_t(axis)] = false;
  const SourceLocation& where = flow.written->where;
  ComponentDescription held{"PartialFixedProjectiveConstraint", {{"name", flow.name + "_other_axes", where}}, where, flow.written->folder};
  for (const char* name : {"indices", "mstate"})
    if (flow.find(name)) held.attributes.push_back({name, flow.text(name), where});
  std::string directions;
  for (const bool each : still) directions += each ? "1 " : "0 ";
  held.attributes.push_back({"fixedDirections", directions, where});
  held.attributes.push_back({"endTime", printReal(times.back()), where});
  flow.place->added_components.push_back(std::move(held));
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
    if (!is_flat) {  // in the order of cells; in SOFA's y comes last
      const std::vector<double> given = numbers;
      constexpr std::size_t places[8] = {0, 3, 7, 4, 1, 2, 6, 5};
      for (std::size_t i = 0; i < count; ++i) numbers[i] = given[places[i]];
    }
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
  const bool flows = type == "LinearVelocityProjectiveConstraint";
  const bool turns = type == "OscillatingTorsionPressureForceField";
  if ((!moves && !spans && !bends && !turns && !swings && !loads && !flows) || !quirks_.use("late-times", element.path())) return;
  const double h = timeStep();
  if (moves) warnOfTurns(element), clearOtherAxes(element);
  if (moves || bends || swings) return element.set("late", "true");
  if (flows) holdOtherAxes(element);
  if (spans) {
    if (type.starts_with("Affine") && element.find("meshIndices")) noEffect(type + ".meshIndices"), element.remove("meshIndices");
    if (type.starts_with("Affine") && isOfFrames(element) && (element.find("quaternion") || element.find("rotation")))
      warn(element.written->where, element, element.find("quaternion") ? "quaternion" : "rotation",
           "turns frames on their way: SOFA's keep their orientation, and at the end have a sum of quaternions, without rotation");
    element.set("velocity", "still");
    return element.set("late", "true");
  }
  const Element* integrator = element.place->nearest("integrator");
  const bool is_explicit = integrator && (integrator->is("EulerExplicitSolver") || integrator->is("CentralDifferenceSolver") ||
                                          integrator->written->type.starts_with("RungeKutta"));
  if (turns) {
    if (is_explicit) return;
    const double frequency = element.find("frequency") ? std::atof(element.text("frequency").c_str()) : 1;
    return element.set("phase", printReal(-2 * std::numbers::pi * frequency * h));
  }
  const char* at = element.find("times") ? "times" : "keyTimes";
  const char* values = flows ? "velocities" : "forces";
  Table table(element.text(at), element.text(values));
  if (table.width == 0) return;
  if (flows && table.width == 3) {
    if (table.times.front() <= 0) {  // SOFA moves them by the first velocity before the first step too
      std::vector<double> ahead = table.at(0);
      for (double& number : ahead) number *= h;
      if (ahead != std::vector<double>(3, 0)) element.set("ahead", printed(ahead));
    }
    return element.set("late", "true");
  }
  if (flows) {  // of frames and numbers
    if (table.times.front() < 0)
      warn(element.written->where, element, at, "begins before the start: SOFA's frames go by the velocities of the starts of steps, and "
                                                "here by their integral");
    if (saysYes(element.text("continueAfterEnd"))) {
      warn(element.written->where, element, "continueAfterEnd",
           "keeps the last velocity, and velocities of frames are those of the moment: SOFA's are a step late, and go on along the line "
           "of the last two keys");
      return;
    }
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
