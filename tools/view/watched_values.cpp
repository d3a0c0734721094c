// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/watched_values.h"

#include <charconv>
#include <vector>

#include "tools/session/statistics.h"

namespace stroma::view {
namespace {

using nlohmann::json;

std::vector<std::string> partsOf(const std::string& word) {
  std::vector<std::string> parts{""};
  for (const char c : word) {
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

long wholeNumber(const std::string& text) {
  long number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : -1;
}

[[noreturn]] void unknown(const std::string& word) {
  throw ComponentError("nothing called '" + word.substr(0, 60) + "' can be watched",
                       "energy, solver, or node.BODY.NODE.position, .velocity or .reaction");
}

}  // namespace

std::optional<WatchedValues::NodeWord> WatchedValues::find(const std::string& word) const {
  const std::vector<std::string> parts = partsOf(word);
  if (parts.size() != 4 || parts[0] != "node") return {};
  const long body = wholeNumber(parts[1]), node = wholeNumber(parts[2]);
  if (body < 0 || body >= long(drawing_.bodies.size())) return {};
  const Body& found = drawing_.bodies[std::size_t(body)];
  if (node < 0 || node >= long(found.page.size()) || found.page[std::size_t(node)] < 0) return {};
  if (parts[3] != "position" && parts[3] != "velocity" && parts[3] != "reaction") return {};
  return NodeWord{&found, Index(node), parts[3]};
}

void WatchedValues::check(const std::string& word) const {
  if (word != "energy" && word != "solver" && !find(word)) unknown(word);
}

Vec3 WatchedValues::reaction(const Body& body, Index row) {
  if (!body.system) return Vec3::Zero();
  const System& system = *body.system;
  if (forces_of_ != &system) {
    forces_.resize(system.allRows());
    for (ForceField* field : system.forceFields()) field->addForce(system.x, system.v, forces_);
    for (const Mass* mass : system.masses()) mass->addGravity(forces_);
    forces_of_ = &system;
  }
  return -Vec3(ConstRows(forces_)[body.state->firstRow() + row]);
}

json WatchedValues::read(const std::set<std::string>& words, const StepReport& last, double step_ms, bool still) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const bool with_costly = still || start >= due_;
  forces_of_ = nullptr;
  json values = json::object();
  for (const std::string& word : words) {
    if (word == "energy") {
      if (!with_costly) continue;
      const Energies energies = energiesOf(simulation_);
      values["energy.kinetic"] = energies.kinetic;
      values["energy.elastic"] = energies.elastic;
      values["energy.gravity"] = energies.gravity;
    } else if (word == "solver") {
      values["step_ms"] = step_ms;
      values["iterations"] = last.linear_iterations;
      values["newton"] = last.newton_iterations;
      values["residual"] = last.linear_residual;
    } else {
      const auto node = find(word);
      if (!node || (node->what == "reaction" && !with_costly)) continue;
      const Vec3 value = node->what == "position"   ? node->body->x()[node->row]
                         : node->what == "velocity" ? node->body->v()[node->row]
                                                    : reaction(*node->body, node->row);
      for (int k = 0; k < 3; ++k) values[word + "." + "xyz"[k]] = value[k];
    }
  }
  const auto now = Clock::now();
  if (with_costly) due_ = now + 100 * (now - start);
  return values;
}

}  // namespace stroma::view
