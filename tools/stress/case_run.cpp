// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/case_run.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>

#include "framework/algebra/parallel.h"
#include "tools/checks/result_doubts.h"
#include "tools/session/drop_readers.h"
#include "tools/session/session.h"
#include "tools/stress/disturbance.h"
#include "tools/stress/force_checks.h"
#include "tools/stress/table.h"

namespace stroma::stress {
namespace {

/// A share of the size of the body that counts as back in its place, or as at rest in a step.
constexpr double near = 0.01, at_rest = 1e-5;
constexpr long steps_before = 2;  ///< of a case that changes something between two steps
constexpr const char* not_made = "there is nothing that this case could move: the list of cases is wrong";

double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// The first number of x or v that is not finite, in words, or empty.
std::string notFinite(const Simulation& simulation) {
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i)
      if (!state->x()[i].allFinite() || !state->v()[i].allFinite())
        return fmt::format("row {} of {} is not finite after step {}", i, state->path(), simulation.steps());
  return {};
}

std::vector<double> positionsOf(const Simulation& simulation) {
  std::vector<double> all;
  for (const auto& system : simulation.systems())
    for (Index row = 0; row < system->allRows(); ++row)
      for (int c = 0; c < 3; ++c) all.push_back(system->x[row][c]);
  return all;
}

/// Of the worst place from where it is in the undisturbed run [sizes]; -1 where rows are not the same.
double distanceFrom(const std::vector<double>& places, const Simulation& simulation) {
  std::size_t at = 0;
  double worst = 0;
  for (const auto& system : simulation.systems()) {
    const double size = sizeOf(*system);
    for (Index row = 0; row < system->allRows(); ++row, at += 3) {
      if (at + 3 > places.size()) return -1;
      if (system->motion().kindOf(row) != RowKind::place) continue;
      worst = std::max(worst, (Vec3(system->x[row]) - Vec3(places[at], places[at + 1], places[at + 2])).norm() / size);
    }
  }
  return at == places.size() ? worst : -1;
}

/// What a doubt is about and of which kind it is: "/liver/fem at t = # s: # of # elements are inverted or flat" of one on
/// "3 of 80 elements ...; the worst is ...".
std::string kindOfDoubt(const std::string& sentence) {
  return withoutNumbers(sentence.substr(0, sentence.find(';')));
}

/// Whether a sentence names a component by its path, or a line of the scene's file. "3 J/m" and "1/s" name nothing.
bool namesSomething(const std::string& sentence, const std::string& scene) {
  for (std::size_t at = sentence.find('/'); at != std::string::npos; at = sentence.find('/', at + 1)) {
    const unsigned char before = at == 0 ? ' ' : static_cast<unsigned char>(sentence[at - 1]);
    const unsigned char after = at + 1 == sentence.size() ? ' ' : static_cast<unsigned char>(sentence[at + 1]);
    // "/.dt" is an attribute of the root
    if (!std::isalnum(before) && before != ')' && (std::isalpha(after) || after == '_' || after == '.')) return true;
  }
  return sentence.find(std::filesystem::path(scene).filename().string() + ":") != std::string::npos;
}

/// `before`: positions before the last step. Statics have no velocities, and may creep all the same: a fluid moves within.
bool isAtRest(const Simulation& simulation, const std::vector<double>& before) {
  for (const auto& system : simulation.systems()) {
    if (!system->integrator().movesInTime()) continue;
    if (!(largest(system->v) * simulation.dt() < at_rest * sizeOf(*system))) return false;
  }
  const double moved = distanceFrom(before, simulation);
  return moved >= 0 && moved < at_rest;
}

/// Whether a body has a shape of its own to come back to. Rigid and free ones may rest in many places.
bool hasShape(const Simulation& simulation) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields())
      if (const ForceTraits traits = field->traits(); traits.forces_balance || traits.has_rest_shape) return true;
  return false;
}

/// What files would hold besides positions: cell fields and energies.
std::string notFiniteElsewhere(const Simulation& simulation) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields())
      for (const std::string& name : field->cellFields()) {
        std::vector<double> values;
        field->cellField(name, system->x, values);
        const auto bad = std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
        if (bad != values.end())
          return fmt::format("{} of {} is not finite at number {} of {}", name, field->path(), bad - values.begin(),
                             values.size());
      }
  const Energies energies = energiesOf(simulation);
  return std::isfinite(energies.kinetic + energies.elastic + energies.gravity) ? "" : "an energy is not finite";
}

/// One case under way.
class CaseRun {
 public:
  CaseRun(const Scenery& scenery, const Case& what, const Undisturbed& undisturbed)
      : scenery_(scenery), what_(what), undisturbed_(undisturbed) {}

  Outcome operator()() {
    prepareProcess();
    try {
      load();
      run();
    } catch (const SceneError& error) {
      stop(error.diagnostics().text());
    } catch (const ComponentError& error) {
      stop(error.what());
    } catch (const std::bad_alloc&) {
      setMemory(RLIM_INFINITY);  // sentences need some
      stop("out of memory");
    } catch (const std::logic_error& error) {
      // of the standard library: no sentence for anybody
      broken(fmt::format("an error that says nothing to a user: {}", error.what()));
    } catch (const std::exception& error) {
      stop(error.what());
    }
    return outcome_;
  }

 private:
  void prepareProcess() {
    if (what_.kind == Kind::threads) setThreads(int(what_.amount));
    if (what_.kind != Kind::memory) return;
    malloc_trim(0);  // what the heap has reserved would be room besides
    std::ifstream file("/proc/self/statm");
    std::size_t pages = 0;
    file >> pages;
    setMemory(rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + rlim_t(what_.amount * 1048576));
  }
  static void setMemory(rlim_t bytes) {
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = std::min(bytes, limit.rlim_max);
    setrlimit(RLIMIT_AS, &limit);
  }

  void load() {
    for (const std::string& module : scenery_.modules) session_.modules().open(module);
    std::vector<Override> overrides = scenery_.overrides;
    if (what_.override) overrides.push_back(*what_.override);
    session_.setOverrides(std::move(overrides));
    dropReaders(session_.load(scenery_.scene));
  }
  Simulation& simulation() { return session_.simulation(); }

  void run() {
    switch (what_.kind) {
      case Kind::forces:
        // what has no node that is free to move is looked at where it is
        if (!disturb(simulation(), what_.shape, what_.amount, what_.seed) && what_.shape != Shape::small)
          return broken(not_made);
        outcome_.sentences = brokenPromises(simulation(), what_.shape == Shape::small, what_.seed);
        outcome_.ending = outcome_.sentences.empty() ? Ending::good : Ending::breaks;
        return;
      case Kind::shape:
        if (!disturb(simulation(), what_.shape, what_.amount, what_.seed)) return broken(not_made);
        break;
      case Kind::move:
        return runMove();
      case Kind::not_finite:
        return runNotFinite();
      default:
        break;
    }
    if (make(scenery_.steps)) end();
  }

  void runMove() {
    if (!make(std::min(steps_before, scenery_.steps))) return;
    if (!moveHeld(simulation(), what_.amount, what_.seed)) return broken(not_made);
    if (!make(std::max(1L, scenery_.steps / 4))) return;
    moveHeld(simulation(), -what_.amount, what_.seed);
    if (make(std::max(1L, scenery_.steps - simulation().steps()))) end();
  }

  void runNotFinite() {
    if (what_.entry == Entry::attribute || what_.entry == Entry::infinite_attribute)
      return broken(fmt::format("{} is taken for a number", what_.text));
    if (!make(std::min(steps_before, scenery_.steps))) return;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (what_.entry == Entry::edit) {
      simulation().setAttribute("/", "dt", "nan");
      return broken("NaN is taken for a dt");
    }
    if (what_.entry == Entry::force) {
      Input input{simulation().states().front()->path(), {0}};
      input.force = Vec3(0, nan, 0);
      simulation().addInput(input);
      return broken("NaN is taken for a force");
    }
    const FreeRow free = freeRow(simulation(), what_.seed);
    if (!free.system) return broken(not_made);
    (what_.entry == Entry::position ? free.system->x : free.system->v)[free.row][1] = nan;
    const RunReport report = session_.run({.steps = 2});
    outcome_.steps = simulation().steps();
    if (report.end != RunEnd::done) return stop(report.reason);
    // an integrator of statics does not read velocities
    if (const std::string bad = notFinite(simulation()); !bad.empty()) return broken(bad + ", and the run goes on");
    outcome_.ending = Ending::good;
  }

  /// Steps; false when the case has ended with one.
  bool make(long steps) {
    std::string bad;
    RunLimits limits;
    limits.steps = steps;
    const long last = simulation().steps() + steps - 1;
    limits.before_step = [&](Simulation& running) {
      if (running.steps() == last) before_ = positionsOf(running);
    };
    limits.reached = [&](const Simulation& running) { return !(bad = notFinite(running)).empty(); };
    const RunReport report = session_.run(limits);
    outcome_.steps = simulation().steps();
    if (!bad.empty()) return broken(bad + ", and the run goes on"), false;
    statistics_ = report.statistics.unconverged;
    if (report.end == RunEnd::done) return true;
    stop(report.reason);
    if (const std::string left = notFinite(simulation()); !left.empty()) broken("after the stop, " + left);
    return false;
  }

  void end() {
    simulation().complete();
    if (what_.kind == Kind::threads) {
      const bool same = simulation().stateHash() == undisturbed_.hash;
      outcome_.ending = same ? Ending::good : Ending::breaks;
      if (!same) outcome_.sentences = {fmt::format("other bits than with one thread")};
      return;
    }
    outcome_.distance = distanceFrom(undisturbed_.positions, simulation());
    outcome_.sentences = doubtsOf(simulation());
    for (std::string& warning : statistics_.warnings()) outcome_.sentences.push_back(std::move(warning));
    if (const std::string bad = notFiniteElsewhere(simulation()); !bad.empty()) return broken(bad);
    const bool is_back = outcome_.distance >= 0 && outcome_.distance < near;
    const bool is_disturbed = what_.kind == Kind::shape || what_.kind == Kind::move;
    // a doubt that the undisturbed run has too is none of this case, but where it is all that tells another shape from it
    const bool is_elsewhere = is_disturbed && !is_back && outcome_.distance >= 0 && hasShape(simulation()) &&
                              isAtRest(simulation(), before_);
    if (!is_elsewhere) std::erase_if(outcome_.sentences, [&](const std::string& one) { return isUndisturbed(one); });
    if (!outcome_.sentences.empty())
      outcome_.ending = Ending::doubt;
    else if (is_elsewhere)
      outcome_.ending = Ending::elsewhere;
    else
      outcome_.ending = is_back && (is_disturbed || what_.kind == Kind::memory) ? Ending::good : Ending::runs;
  }

  bool isUndisturbed(const std::string& doubt) const {
    return std::any_of(undisturbed_.doubts.begin(), undisturbed_.doubts.end(),
                       [&](const std::string& other) { return kindOfDoubt(other) == kindOfDoubt(doubt); });
  }

  /// A sentence tells a person something: it has words, and names what it is about.
  void stop(const std::string& reason) {
    outcome_.ending = Ending::stops;
    outcome_.sentences = {reason};
    // memory belongs to no component, and the command says so by itself
    const bool names = namesSomething(reason, scenery_.scene) || what_.kind == Kind::memory ||
                       what_.entry == Entry::edit || what_.entry == Entry::force;
    if (reason.empty()) broken("it stops without a sentence");
    if (reason.find("std::") != std::string::npos) return broken("it stops with words of the program's own: " + reason);
    if (!reason.empty() && !names) broken("it stops with a sentence that names no component: " + reason);
  }
  void broken(const std::string& what) {
    outcome_.ending = Ending::breaks;
    outcome_.sentences = {what};
  }

  const Scenery& scenery_;
  const Case& what_;
  const Undisturbed& undisturbed_;
  Session session_;
  UnconvergedSteps statistics_;
  std::vector<double> before_;  ///< positions before the last step
  Outcome outcome_;
};

}  // namespace

Undisturbed runUndisturbed(const Scenery& scenery) {
  Undisturbed undisturbed;
  const double start = processorSeconds();
  Session session;
  for (const std::string& module : scenery.modules) session.modules().open(module);
  session.setOverrides(scenery.overrides);
  Simulation& simulation = session.load(scenery.scene);
  dropReaders(simulation);
  const RunReport report = session.run({.steps = scenery.steps});
  if (report.end != RunEnd::done) undisturbed.failure = report.reason;
  if (undisturbed.failure.empty()) undisturbed.failure = notFinite(simulation);
  undisturbed.doubts = doubtsOf(simulation);
  for (std::string& warning : report.statistics.unconverged.warnings())
    undisturbed.doubts.push_back(std::move(warning));
  undisturbed.hash = simulation.stateHash();
  undisturbed.positions = positionsOf(simulation);
  undisturbed.seconds = processorSeconds() - start;
  return undisturbed;
}

Outcome runCase(const Scenery& scenery, const Case& what, const Undisturbed& undisturbed) {
  return CaseRun(scenery, what, undisturbed)();
}

}  // namespace stroma::stress
