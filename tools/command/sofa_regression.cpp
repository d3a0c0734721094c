// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes against the states that SOFA stored for them. SOFA writes at the start of a step: the last of n instants is at
// (n - 1) h. A case passes when, at every stored instant, |x - x_ref|_2 is at most the tolerance times the largest
// |x_ref(t) - x_ref(0)|_2. Places, orientations (by their angles, since q and -q are the same) and numbers are judged apart,
// each by a size of its own. A case that does not pass is run again from positions moved by 1e-9 of the body, and orientations
// by 1e-9 rad: where the two runs differ by more than the tolerance, no other program can do better, and the case is neither
// passed nor failed.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/mechanics/mapping.h"
#include "framework/mechanics/signs.h"
#include "framework/scene/node.h"
#include "framework/scene/output_file.h"
#include "framework/simulation/integrator.h"
#include "tools/command/comparison.h"
#include "tools/command/job_limits.h"
#include "tools/command/junit.h"
#include "tools/command/session.h"
#include "tools/command/sofa_references.h"
#include "tools/command/sofa_runs.h"
#include "tools/session/children.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;
using Instants = std::map<double, std::vector<double>>;
using Kinds = std::vector<RowKind>;  ///< of the rows of a state; empty: all are places

RowKind kindOf(const Kinds& kinds, std::size_t row) { return row < kinds.size() ? kinds[row] : RowKind::place; }
int numbersIn(RowKind kind) { return kind == RowKind::place ? 3 : kind == RowKind::turn ? 4 : 1; }

/// The numbers that SOFA writes of a state.
std::vector<double> numbersOf(const State& state) {
  std::vector<double> numbers;
  const ConstRows rows = state.x();
  for (Index i = 0; i < state.size(); ++i) {
    const double* row = rows.data + std::size_t(i) * row_doubles;
    for (int c = 0; c < numbersIn(state.kindOf(i)); ++c) numbers.push_back(row[c]);
  }
  return numbers;
}

bool isName(const std::string& name, const std::string& wanted) { return name == wanted || name + "1" == wanted; }

/// What SOFA counts: below an integrator; with `mapped` also what a mapping places, and with `outermost` what is in the outermost node.
std::vector<State*> countedStates(const Node& root, bool mapped, bool simulated, bool outermost) {
  std::vector<State*> all;
  std::vector<Mapping*> mappings;
  root.collect(all);
  root.collect(mappings);
  const auto follows = [&](const State* state) {
    return std::ranges::any_of(mappings, [state](const Mapping* m) { return &m->output() == state; });
  };
  const auto moves = [](const State* state) {  // what holds others here is of the dialect, and SOFA has none there
    for (const Node* node = &state->node(); node; node = node->parent())
      for (const auto& each : node->components())
        if (dynamic_cast<const Integrator*>(each.get()) && !each->name().starts_with("held_by_the_scene_")) return true;
    return false;
  };
  std::erase_if(all, [&](const State* state) {
    return (!mapped && follows(state)) || (simulated && !moves(state)) || (!outermost && &state->node() == &root);
  });
  return all;
}

bool isOf(const SofaReference& reference, const State& state) {
  std::size_t numbers = 0;
  for (Index i = 0; i < state.size(); ++i) numbers += std::size_t(numbersIn(state.kindOf(i)));
  return isName(state.name(), reference.state) && numbers == reference.positions.begin()->second.size();
}

/// The states that references are of. SOFA's two programs for it number the states from the top down, the newer one without the
/// outermost node's own: the first way to count by which names and numbers of nodes fit, one without other states if there is one.
/// Else each by its name.
std::vector<const State*> statesOf(const std::vector<SofaReference>& references, const Node& root, bool mapped_too) {
  for (int way = 0; way < 16; ++way) {  // ways with all of their states stored, that move, that the list asks for, with the outermost node
    const bool all_stored = !(way & 8), simulated = !(way & 4), mapped = mapped_too != bool(way & 2), outermost = !(way & 1);
    const std::vector<State*> counted = countedStates(root, mapped, simulated, outermost);
    if (all_stored && counted.size() != references.size()) continue;
    std::vector<const State*> found;
    for (const SofaReference& reference : references) {
      const auto number = std::size_t(reference.number);
      if (number < counted.size() && isOf(reference, *counted[number])) found.push_back(counted[number]);
    }
    if (found.size() == references.size()) return found;
  }
  std::vector<const State*> found;
  const std::vector<State*> all = countedStates(root, true, false, true);
  for (const SofaReference& reference : references) {
    const State* one = nullptr;
    const bool fits = std::ranges::any_of(all, [&](const State* state) { return isOf(reference, *state); });
    for (const State* state : all) {
      if (fits ? !isOf(reference, *state) : !isName(state->name(), reference.state)) continue;
      if (one) throw std::runtime_error("several states are called " + reference.state);
      one = state;
    }
    if (!one) throw std::runtime_error("no state is called " + reference.state);
    found.push_back(one);
  }
  return found;
}

/// Every place and number by another way, up to this share of the body's distance from the origin; orientations by angles [rad].
void moveALittle(Simulation& simulation, double shift) {
  for (const auto& system : simulation.systems()) {
    std::array<double, 3> size{};
    const auto sizeOf = [&](RowKind kind) -> double& { return size[std::size_t(kind)]; };
    for (Index i = 0; i < system->independentRows(); ++i)
      sizeOf(system->motion().kindOf(i)) = std::max(sizeOf(system->motion().kindOf(i)), Vec3(system->x[i]).norm());
    sizeOf(RowKind::turn) = 1;
    for (Index i = 0; i < system->independentRows(); ++i) {
      const RowKind kind = system->motion().kindOf(i);
      const Vec3 way = shift * sizeOf(kind) / 3 * Vec3((i * 7 + 3) % 5 - 2, (i * 11 + 5) % 7 - 3, (i * 13 + 4) % 5 - 2);
      system->motion().advanceRow(kind == RowKind::value ? Vec3(way[1], 0, 0) : way, system->x, i);
    }
  }
}

/// Runs as far as the references go. `shift`: how far positions are moved at the start, as a share of the body; `step`: set to
/// the scene's; `kinds`: to those of the states.
std::vector<Instants> run(const SofaCase& test, const std::vector<SofaReference>& references, double shift, double& step,
                          std::vector<Kinds>& kinds) {
  Session session;
  Simulation& simulation = session.load(test.scene, {{"/", "dialect", "sofa"}});
  dropWriters(simulation);
  session.followMeshChanges();
  double last = 0;
  kinds.clear();
  for (const State* state : statesOf(references, simulation.root(), test.mapped_too)) kinds.push_back(state->row_kinds);
  const auto stateAt = [&](std::size_t r) { return statesOf(references, simulation.root(), test.mapped_too)[r]; };
  for (const SofaReference& reference : references) {
    last = std::max(last, reference.positions.rbegin()->first);
  }
  if (shift != 0) moveALittle(simulation, shift);
  std::vector<Instants> found(references.size());
  step = simulation.dt();
  const double h = step, begin = simulation.time();
  for (long k = 0;; ++k) {
    const double t = double(k) * h;
    for (std::size_t r = 0; r < references.size(); ++r)
      for (const auto& [time, values] : references[r].positions)
        if (std::abs(time - begin - t) < 0.01 * h || std::abs(time - t) < 0.01 * h)
          if (const State* state = stateAt(r); state->isBound()) found[r][time] = numbersOf(*state);
    if (t > last - 0.5 * h) return found;
    const StepReport report = session.step();
    if (report.failed())
      throw std::runtime_error(fmt::format("ended at t = {:g} of {:g}: {}", simulation.time(), last, report.reason));
  }
}

/// What the list asks for and a reference lacks, or empty: a stored instant in the last period. A period that the list does not
/// give is taken for the least time between two instants.
std::string earlyEnd(const SofaCase& test, const std::vector<SofaReference>& references, double h) {
  const double end = double(test.steps - 1) * h;
  for (const SofaReference& reference : references) {
    double period = test.period;
    if (period == 0 && !test.last_only && reference.positions.size() > 2) {
      period = std::numeric_limits<double>::infinity();
      for (auto at = std::next(reference.positions.begin()); at != reference.positions.end(); ++at)
        period = std::min(period, at->first - std::prev(at)->first);
    }
    const double last = reference.positions.rbegin()->first;
    if (last < end - std::max(period, h) + 0.5 * h)
      return fmt::format("the reference of {} ends at t = {:g}, and {} steps at t = {:g}: nothing is compared after it",
                         reference.state, last, test.steps, end);
  }
  return {};
}

/// Of places, numbers and orientations, in this order.
struct Difference {
  std::array<double, 3> largest{};   ///< of a coordinate [m], a number, an angle [rad]
  std::array<double, 3> relative{};  ///< in L2, of the largest displacement
  std::array<bool, 3> is_there{};
  double sofa = 0;                   ///< SOFA's own: the mean of all numbers over the number of points
  double worst() const { return *std::max_element(relative.begin(), relative.end()); }
};
constexpr std::array<const char*, 3> kind_names = {"positions", "numbers", "orientations"};
static_assert(int(RowKind::place) == 0 && int(RowKind::value) == 1 && int(RowKind::turn) == 2);

/// The numbers of one instant as rows in the form of State::position.
std::vector<Vec3> rowsOf(const std::vector<double>& numbers, const Kinds& kinds, const std::string& name, double time) {
  std::vector<Vec3> rows;
  for (std::size_t at = 0; at < numbers.size();) {
    const RowKind kind = kindOf(kinds, rows.size());
    const std::size_t count = std::size_t(numbersIn(kind));
    if (at + count > numbers.size()) throw std::runtime_error(fmt::format("{} has {} numbers at t = {:g}", name, numbers.size(), time));
    const double* const from = numbers.data() + at;
    for (std::size_t c = 0; c < count; ++c)
      if (!std::isfinite(from[c])) throw std::runtime_error(fmt::format("{} is not finite at t = {:g}", name, time));
    at += count;
    if (kind == RowKind::turn) {
      const Quaternion q(from);
      if (!(std::abs(q.norm() - 1) < 1e-2))
        throw std::runtime_error(fmt::format("{} at t = {:g}: the quaternion of frame {} has the length {:.4g}", name, time,
                                             rows.size() / 2, q.norm()));
      rows.push_back(signedRotationVector(q.normalized()));
    } else {
      rows.emplace_back(from[0], count > 1 ? from[1] : 0, count > 1 ? from[2] : 0);
    }
  }
  return rows;
}

/// Sums of squares of the ways from one instant to another.
std::array<double, 3> squaresOf(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const Kinds& kinds, Difference* worst) {
  std::array<double, 3> sums{};
  for (std::size_t i = 0; i < std::min(from.size(), to.size()); ++i) {
    const RowKind kind = kindOf(kinds, i);
    const std::size_t k = std::size_t(kind);
    const Vec3 way = wayBetween(kind, from[i], to[i]);
    sums[k] += way.squaredNorm();
    if (worst) worst->largest[k] = std::max(worst->largest[k], kind == RowKind::turn ? way.norm() : way.cwiseAbs().maxCoeff());
  }
  return sums;
}

/// The largest displacement of each kind. Where nothing moves, what round-off of the numbers in a file could be.
std::array<double, 3> sizesOf(const Instants& reference, const Kinds& kinds, const std::string& name, Difference& worst) {
  const std::vector<Vec3> start = rowsOf(reference.begin()->second, kinds, name, reference.begin()->first);
  std::array<double, 3> sizes{}, least{};
  for (const auto& [time, values] : reference) {
    const std::array<double, 3> sums = squaresOf(start, rowsOf(values, kinds, name, time), kinds, nullptr);
    for (std::size_t k = 0; k < 3; ++k) sizes[k] = std::max(sizes[k], std::sqrt(sums[k]));
  }
  double body = 0, turns = 0;
  for (const double value : reference.begin()->second) body += value * value;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const RowKind kind = kindOf(kinds, i);
    worst.is_there[std::size_t(kind)] = true;
    turns += kind == RowKind::turn;
  }
  constexpr double smallest = 1e-9, six_digits = 1e-3;  // with a tolerance of 1e-3: angles that six digits tell apart
  least[0] = least[1] = std::max(smallest * std::sqrt(body), 1e-300);
  least[2] = std::max(six_digits * std::sqrt(turns), 1e-300);
  for (std::size_t k = 0; k < 3; ++k) sizes[k] = std::max(sizes[k], least[k]);
  return sizes;
}

Difference differenceOf(const Instants& reference, const Instants& actual, const Kinds& kinds, const std::string& name) {
  for (const auto& [time, values] : reference) {
    const auto found = actual.find(time);
    if (found == actual.end()) throw std::runtime_error(fmt::format("{} has no instant at t = {:g}", name, time));
    if (found->second.size() != values.size())
      throw std::runtime_error(fmt::format("{} has {} numbers, and its reference {}", name, found->second.size(), values.size()));
  }
  Difference worst;
  const std::string other = "the reference of " + name;
  const std::array<double, 3> sizes = sizesOf(reference, kinds, other, worst);
  for (const auto& [time, values] : reference) {
    const std::vector<double>& found = actual.at(time);
    const std::array<double, 3> sums =
        squaresOf(rowsOf(values, kinds, other, time), rowsOf(found, kinds, name, time), kinds, &worst);
    for (std::size_t k = 0; k < 3; ++k) worst.relative[k] = std::max(worst.relative[k], std::sqrt(sums[k]) / sizes[k]);
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += std::abs(found[i] - values[i]);
    const auto count = double(values.size());
    worst.sofa = std::max(worst.sofa, sum / count / std::max(1., count / 3));
  }
  return worst;
}

Difference worstOf(const std::vector<SofaReference>& references, const std::vector<Instants>& wanted,
                   const std::vector<Instants>& actual, const std::vector<Kinds>& kinds) {
  Difference worst;
  for (std::size_t r = 0; r < references.size(); ++r) {
    const Difference one = differenceOf(wanted[r], actual[r], kinds[r], references[r].state);
    for (std::size_t k = 0; k < 3; ++k) {
      worst.largest[k] = std::max(worst.largest[k], one.largest[k]);
      worst.relative[k] = std::max(worst.relative[k], one.relative[k]);
      worst.is_there[k] |= one.is_there[k];
    }
    worst.sofa = std::max(worst.sofa, one.sofa);
  }
  return worst;
}

Json toJson(const Difference& found) {
  Json largest = Json::object(), relative = Json::object();
  for (std::size_t k = 0; k < 3; ++k)
    if (found.is_there[k]) largest[kind_names[k]] = found.largest[k], relative[kind_names[k]] = found.relative[k];
  const double first = found.largest[found.is_there[0] ? 0 : found.is_there[1] ? 1 : 2];
  return {{"largest", first}, {"relative", found.worst()}, {"relative_of", relative}, {"largest_of", largest}, {"sofa", found.sofa}};
}

/// In a process of its own: JSON of the verdict.
std::string judge(const SofaCase& test, double tolerance) {
  const auto start = std::chrono::steady_clock::now();
  Json result{{"name", test.name}, {"verdict", "failed"}};
  try {
    if (!std::filesystem::exists(test.scene))
      throw std::runtime_error(test.scene + " is not there, nor in a folder of REGRESSION_SCENES_DIR or STROMA_DATA_PATH");
    if (test.references.empty()) throw std::runtime_error("there is no reference");
    std::vector<SofaReference> references;
    std::vector<Instants> wanted;
    for (const std::string& file : test.references) {
      references.push_back(readSofaReference(file));
      wanted.push_back(references.back().positions);
    }
    double h = 0;
    std::vector<Kinds> kinds;
    const std::vector<Instants> actual = run(test, references, 0, h, kinds);
    if (const std::string early = earlyEnd(test, references, h); !early.empty()) result["remark"] = early;
    const Difference found = worstOf(references, wanted, actual, kinds);
    result.update(toJson(found));
    result["sofa_passes"] = found.sofa <= test.epsilon;
    if (found.worst() <= tolerance) {
      result["verdict"] = "passed";
    } else {
      constexpr double nothing = 1e-9;
      const std::vector<Instants> moved = run(test, references, nothing, h, kinds);
      const double sensitivity = worstOf(references, actual, moved, kinds).worst();
      result["sensitivity"] = sensitivity;
      if (sensitivity > tolerance) result["verdict"] = "undecided";
    }
  } catch (const SceneError& error) {
    result["reason"] = "does not load: " + error.diagnostics().text();
  } catch (const std::exception& error) {
    result["reason"] = error.what();
  }
  result["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string sentence(const Json& result, double epsilon) {
  std::string text;
  if (result.contains("relative")) {
    std::string parts, largest;
    for (const auto& [kind, share] : result["relative_of"].items()) {
      parts += fmt::format("{}{} {:.3g}", parts.empty() ? "" : ", ", kind, share.get<double>());
      const char* const unit = kind == kind_names[0] ? " m" : kind == kind_names[2] ? " rad" : "";
      largest += fmt::format("{}{:.3g}{}", largest.empty() ? "" : ", ", result["largest_of"][kind].get<double>(), unit);
    }
    text = fmt::format("relative {:.3g}{}, largest {}, SOFA's test {:.3g} of {:g} ({})", result["relative"].get<double>(),
                       result["relative_of"].size() > 1 ? " (" + parts + ")" : "", largest, result["sofa"].get<double>(), epsilon,
                       result["sofa_passes"].get<bool>() ? "passes" : "fails");
  }
  if (result.contains("sensitivity"))
    text += fmt::format(", a start moved by 1e-9 changes {:.3g}", result["sensitivity"].get<double>());
  for (const char* more : {"remark", "reason"})
    if (result.contains(more)) text += (text.empty() ? "" : "; ") + result[more].get<std::string>();
  return text;
}

}  // namespace

int regressSofaLists(const std::string& where, const Values& values) {
  for (const char* other : {"update", "bits", "set", "threads"})
    if (values.count(other))
      throw UsageError(fmt::format("--{} is of the project's own lists: what {} compares are states that SOFA stored", other, where));
  std::vector<SofaCase> cases;
  for (const std::string& list : isSofaList(where) ? std::vector<std::string>{where} : sofaListsIn(where))
    for (SofaCase& one : readSofaList(list)) cases.push_back(std::move(one));
  const std::string filter = textOf(values, "filter");
  std::erase_if(cases, [&](const SofaCase& test) { return test.name.find(filter) == std::string::npos; });
  if (cases.empty()) throw UsageError(fmt::format("--filter {}: no case of the list has that in its name", filter));
  const double tolerance = values["tolerance"].as<double>();
  const JobLimits limits = jobLimitsOf(values);
  int passed = 0, failed = 0, undecided = 0;
  Json all = Json::array();
  std::vector<JunitCase> junit;
  runJobs(
      int(cases.size()), limits, [&](int i) { return judge(cases[std::size_t(i)], tolerance); },
      [&](int i, const ChildEnd& end) {
        const SofaCase& test = cases[std::size_t(i)];
        Json result = end.failure.empty() ? Json::parse(end.text)
                                          : Json{{"name", test.name}, {"verdict", "failed"}, {"reason", end.failure}};
        const std::string verdict = result["verdict"];
        ++(verdict == "passed" ? passed : verdict == "failed" ? failed : undecided);
        const std::string text = sentence(result, test.epsilon);
        fmt::print("{:9} {}: {}\n", verdict, test.name, text);
        std::fflush(stdout);
        if (verdict != "undecided")
          junit.push_back({test.name, result.value("seconds", 0.), verdict == "failed" ? text : std::string()});
        all.push_back(std::move(result));
      });
  fmt::print("{} passed, {} failed, {} undecided: no other program can match them\n", passed, failed, undecided);
  if (values.count("json"))
    writeWholeFile(textOf(values, "json"), all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  if (values.count("junit")) writeJunit("stroma regress", junit, textOf(values, "junit"));
  return failed == 0 ? exit_done : exit_comparison_failed;
}

}  // namespace stroma::command
