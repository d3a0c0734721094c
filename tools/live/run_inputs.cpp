// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces from outside: checked and recorded.
#include "framework/simulation/run_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/scene/names.h"
#include "framework/simulation/integrator.h"

namespace stroma {

namespace {

constexpr const char* input_that_acts = "one that was added, and that remove(), reset() or restore() has not ended";

void checkBall(const Input& input, const State& state) {
  if (!input.nodes.empty() || !input.targets.empty() || !input.force.isZero(0))
    throw ComponentError("an input has a ball and also nodes, targets or a force",
                         "a ball, or nodes: one input for each");
  const auto& [centre, radius] = *input.ball;
  if (!centre.allFinite() || !std::isfinite(radius) || !(radius > 0))
    throw ComponentError("a number of a ball is not finite, or its radius is not positive",
                         "a finite centre and a radius of more than 0");
  for (Index i = 0; i < state.size(); ++i)
    if (state.kindOf(i) == RowKind::place) return;
  throw ComponentError(fmt::format("a ball pushes places, and {} has none", state.path()), "a state with points");
}

void checkNodes(const Input& input, const State& state) {
  for (const Index node : input.nodes)
    if (node < 0 || node >= state.size())
      throw ComponentError(fmt::format("an input names node {}", node),
                           fmt::format("nodes 0 to {} of {}", state.size() - 1, state.path()));
  if (input.nodes.empty()) throw ComponentError("an input names no node", "the nodes it acts on, or a ball");
  if (!input.targets.empty() && input.targets.size() != input.nodes.size())
    throw ComponentError(fmt::format("an input has {} targets for {} nodes", input.targets.size(), input.nodes.size()),
                         "one target per node, or none");
  if (input.targets.empty() && input.stiffness != 0)
    throw ComponentError("an input has a stiffness and no targets", "a target per node, or stiffness 0");
}

}  // namespace

void checkInput(const Input& input, const State& state) {
  input.ball ? checkBall(input, state) : checkNodes(input, state);
  bool finite = input.force.allFinite() && std::isfinite(input.stiffness) && std::isfinite(input.damping);
  for (const Vec3& target : input.targets) finite = finite && target.allFinite();
  if (!finite || input.stiffness < 0 || input.damping < 0)
    throw ComponentError("a number of an input is not finite, or its stiffness or damping is negative",
                         "finite numbers, stiffness and damping of 0 or more");
}

RunInputs::RunInputs(const std::unique_ptr<Node>& root, const Systems& systems, const RunClock& clock, RunLog& log, RunWatch& watch)
    : root_(root), systems_(systems), clock_(clock), log_(log), watch_(watch) {}

System& RunInputs::systemOf(const Input& input, State*& state) const {
  std::vector<State*> states;
  root_->collect(states);
  std::erase_if(states, [](const State* candidate) { return !candidate->isBound(); });
  std::vector<std::string> paths;
  for (State* candidate : states) {
    paths.push_back(candidate->path());
    if (candidate->path() == input.state) state = candidate;
  }
  if (!state)
    throw ComponentError(fmt::format("no state that moves is called '{}'", input.state), "the path of a state",
                         nearest(input.state, paths));
  for (const auto& system : systems_) {
    const auto& own = system->states();
    if (std::find(own.begin(), own.end(), state) == own.end()) continue;
    if (state->firstRow() >= system->independentRows())
      throw ComponentError(
          fmt::format("no input acts on {}: its positions follow from another state by a mapping", state->path()),
          "nodes of the state that is mapped from");
    return *system;
  }
  throw ComponentError(fmt::format("no integrator moves {}", state->path()));
}

void RunInputs::check(const Input& input) const {
  State* state = nullptr;
  System& system = systemOf(input, state);
  checkInput(input, *state);
  if (const StateOwner* owner = system.integrator().stateOwner()) owner->checkInputOn(*state, input);
}

void RunInputs::set(long number, const Input& input) {
  State* state = nullptr;
  System& system = systemOf(input, state);
  checkInput(input, *state);
  if (const StateOwner* owner = system.integrator().stateOwner()) owner->checkInputOn(*state, input);
  const auto known = inputs_.find(number);
  if (known != inputs_.end() && known->second.state != input.state)
    throw ComponentError(fmt::format("input {} acts on {}", number, known->second.state),
                         "the same state, or another input");
  system.setInput(number, input, *state);
  inputs_[number] = input;
  log_.record(clock_.steps(), InputChange{number, input});
  reserve(number + 1);
  watch_.noteWork();
}

long RunInputs::add(const Input& input) {
  const long number = next_;
  set(number, input);
  return number;
}

void RunInputs::change(long number, const Input& input) {
  if (!has(number))
    throw ComponentError(fmt::format("there is no input {}", number), input_that_acts);
  set(number, input);
}

void RunInputs::remove(long number) {
  if (inputs_.erase(number) == 0)
    throw ComponentError(fmt::format("there is no input {}", number), input_that_acts);
  for (const auto& system : systems_) system->removeInput(number);
  log_.record(clock_.steps(), InputChange{number, std::nullopt});
}

void RunInputs::drop(long next_number) {
  for (const auto& [number, input] : inputs_)
    for (const auto& system : systems_) system->removeInput(number);
  inputs_.clear();
  next_ = next_number;
}

void RunInputs::serialize(Archive& archive) {
  std::vector<long> numbers;
  for (const auto& [number, input] : inputs_) numbers.push_back(number);
  archive.list("numbers", numbers);
  archive.value("next", next_);
  for (const long number : numbers) {
    const std::string name = std::to_string(number) + " ";
    Input input = archive.isReading() ? Input() : inputs_[number];
    archive.value(name + "state", input.state);
    archive.list(name + "nodes", input.nodes);
    archive.rows(name + "force", input.force.data(), 3);
    archive.list(name + "targets", input.targets);
    archive.value(name + "stiffness", input.stiffness);
    archive.value(name + "damping", input.damping);
    std::vector<double> ball;  // centre and radius, or nothing
    if (input.ball) ball = {input.ball->centre[0], input.ball->centre[1], input.ball->centre[2], input.ball->radius};
    archive.list(name + "ball", ball);
    if (!ball.empty() && ball.size() != 4)
      throw std::runtime_error(fmt::format("the ball of input {} has {} numbers, not 4", number, ball.size()));
    if (!ball.empty()) input.ball = Ball{{ball[0], ball[1], ball[2]}, ball[3]};
    if (archive.isReading()) set(number, input);
  }
}

}  // namespace stroma
