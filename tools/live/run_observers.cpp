// SPDX-License-Identifier: LGPL-2.1-or-later
// A simulation and its observers: their notifications, and restrictions on their files.
#include "framework/simulation/run_observers.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "framework/scene/node.h"
#include "framework/scene/output_file.h"
#include "framework/scene/spans.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

RunObservers::RunObservers(const Simulation& simulation, const Systems& systems) : simulation_(simulation), systems_(systems) {}

void RunObservers::collect(Node& root) { root.collect(observers_); }

void RunObservers::compile(Diagnostics& diagnostics) {
  for (Observer* observer : observers_) {
    try {
      observer->compile(simulation_);
    } catch (const ComponentError& error) {
      diagnostics.error(observer->where(), observer->path(), error.what(), error.expected, error.suggestion);
    }
  }
}

void RunObservers::watchFollowers() {
  std::vector<Index> watched;
  for (const auto& system : systems_)
    for (const Mapping* mapping : system->actors().passive_mappings)
      for (const Observer* observer : observers_) observer->addWatchedNodes(mapping->output(), watched);
  watches_followers_ = !watched.empty();
}

void RunObservers::checkOutputs() const {
  Diagnostics problems;
  for (const Observer* observer : observers_) {
    try {
      for (const std::string& file : observer->files()) checkAccess(file, observer->replacesFiles());
    } catch (const OutputError& error) {
      problems.error(observer->where(), observer->path(), error.what());
    }
  }
  if (problems.hasErrors()) throw SceneError(std::move(problems));
}

void RunObservers::begin() {
  if (begun_) return;
  // before the first of them replaces a file
  for (const Observer* observer : observers_)
    for (const std::string& file : observer->files()) checkWritable(file, observer->replacesFiles());
  begun_ = true;
  for (Observer* observer : observers_) heard("observe", observer)->begin(simulation_);
}

/// An output that fails does not keep the others from what they have to write.
template <class Tell>
void RunObservers::tellAll(Tell&& tell) {
  std::exception_ptr failure;
  for (Observer* observer : observers_) {
    try {
      tell(*observer);
    } catch (const OutputError&) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

void RunObservers::afterStep(const StepContext& context) {
  const auto reads_all = [&](const Observer* observer) {
    return watches_followers_ || observer->readsAllNodes(context);
  };
  if (!on_demand_ || std::any_of(observers_.begin(), observers_.end(), reads_all)) complete(systems_);
  if (observers_.empty()) return;
  const auto start = Clock::now();
  tellAll([&](Observer& observer) { heard("observe", &observer)->afterStep(simulation_, context); });
  if (!systems_.empty())
    systems_.front()->times.observers += std::chrono::duration<double>(Clock::now() - start).count();
}

void RunObservers::end() {
  complete(systems_);
  if (!begun_) return;
  begun_ = false;
  tellAll([&](Observer& observer) { heard("observe", &observer)->end(simulation_); });
}

void RunObservers::add(Observer& observer) {
  if (std::find(observers_.begin(), observers_.end(), &observer) != observers_.end()) return;
  observer.compile(simulation_);
  observers_.push_back(&observer);
  std::vector<Index> watched;  // an integrator keeps those up to date that were known when it was compiled
  for (const State* state : simulation_.states()) observer.addWatchedNodes(*state, watched);
  watches_followers_ = watches_followers_ || !watched.empty();
  if (!begun_) return;
  complete(systems_);
  observer.begin(simulation_);
}

void RunObservers::remove(Observer& observer) {
  if (std::erase(observers_, &observer) > 0 && begun_) observer.end(simulation_);
}

}  // namespace stroma
