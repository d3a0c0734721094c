// SPDX-License-Identifier: LGPL-2.1-or-later
// A simulation and its observers: what they are told, and what their files must not be.
#include <algorithm>
#include <chrono>
#include <exception>

#include "framework/scene/output_file.h"
#include "framework/simulation/file_uses.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

using Clock = std::chrono::steady_clock;

/// What a run would write over what the scene reads, or over what another observer writes.
void checkOverwriting(const std::vector<Observer*>& observers, const Scene& scene, Diagnostics& diagnostics) {
  const std::vector<FileUse> inputs = inputsOf(scene);
  std::vector<FileUse> outputs;
  for (const Observer* observer : observers) {
    for (const std::string& file : observer->files()) outputs.push_back({file, observer->path(), observer->replacesFiles()});
    const std::optional<std::string> sentence = overwriting(outputs, inputs);
    if (!sentence) continue;
    diagnostics.error(observer->where(), observer->path(), *sentence, "a file of its own");
    return;
  }
}

}  // namespace

void Simulation::compileObservers(Diagnostics& diagnostics) {
  for (Observer* observer : observers_) {
    try {
      observer->compile(*this);
    } catch (const ComponentError& error) {
      diagnostics.error(observer->where(), observer->path(), error.what(), error.expected, error.suggestion);
    }
  }
  if (!observers_.empty()) checkOverwriting(observers_, scene_, diagnostics);
}

/// Single nodes that are watched are kept up to date, but for those that follow others.
void Simulation::watchFollowers() {
  std::vector<Index> watched;
  for (const auto& system : systems_)
    for (const Mapping* mapping : system->actors().passive_mappings)
      for (const Observer* observer : observers_) observer->addWatchedNodes(mapping->output(), watched);
  watches_followers_ = !watched.empty();
}

void Simulation::checkOutputs() const {
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

void Simulation::begin() {
  if (begun_) return;
  // before the first of them replaces a file
  for (const FileUse& output : outputsOf(*this)) checkWritable(output.path, output.is_replaced);
  begun_ = true;
  for (Observer* observer : observers_) observer->begin(*this);
}

/// An output that fails does not keep the others from what they have to write.
template <class Tell>
void Simulation::tellAll(Tell&& tell) {
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

void Simulation::notify(const StepContext& context) {
  const auto reads_all = [&](const Observer* observer) {
    return watches_followers_ || observer->readsAllNodes(context);
  };
  if (!on_demand_ || std::any_of(observers_.begin(), observers_.end(), reads_all)) complete();
  if (observers_.empty()) return;
  const auto start = Clock::now();
  tellAll([&](Observer& observer) { observer.afterStep(*this, context); });
  if (!systems_.empty())
    systems_.front()->times.observers += std::chrono::duration<double>(Clock::now() - start).count();
}

void Simulation::end() {
  complete();
  if (!begun_) return;
  begun_ = false;
  tellAll([&](Observer& observer) { observer.end(*this); });
}

void Simulation::addObserver(Observer& observer) {
  if (std::find(observers_.begin(), observers_.end(), &observer) != observers_.end()) return;
  observer.compile(*this);
  observers_.push_back(&observer);
  std::vector<Index> watched;  // an integrator keeps those up to date that were known when it was compiled
  for (const State* state : states()) observer.addWatchedNodes(*state, watched);
  watches_followers_ = watches_followers_ || !watched.empty();
  if (!begun_) return;
  complete();
  observer.begin(*this);
}

void Simulation::removeObserver(Observer& observer) {
  if (std::erase(observers_, &observer) > 0 && begun_) observer.end(*this);
}

}  // namespace stroma
