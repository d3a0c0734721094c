// SPDX-License-Identifier: LGPL-2.1-or-later
// A simulation that goes on with another tree in the place of its own: the same scene with other meshes.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <tuple>

#include "framework/simulation/simulation.h"
#include "tools/platform/error_sentence.h"

namespace stroma {
namespace {

std::vector<Observer*> inTree(const std::vector<Observer*>& all, const Node& root) {
  std::vector<Observer*> own, found;
  root.collect(own);
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&own](Observer* observer) { return std::find(own.begin(), own.end(), observer) != own.end(); });
  return found;
}

/// Those of another tree whose namesakes look on here, and whoever looks on from outside the tree.
std::vector<Observer*> successors(const std::vector<Observer*>& present, const Node& root,
                                  const std::vector<Observer*>& others) {
  const std::vector<Observer*> own = inTree(present, root);
  std::set<std::string> paths;
  for (const Observer* observer : own) paths.insert(observer->path());
  std::vector<Observer*> all;
  std::copy_if(others.begin(), others.end(), std::back_inserter(all),
               [&paths](const Observer* observer) { return paths.count(observer->path()) > 0; });
  std::copy_if(present.begin(), present.end(), std::back_inserter(all),
               [&own](Observer* observer) { return std::find(own.begin(), own.end(), observer) == own.end(); });
  return all;
}

/// An attribute that cannot be so in this tree keeps its value, with a warning.
void setAll(RunEdits& edits, const std::vector<Override>& all, Diagnostics& diagnostics) {
  for (const Override& edit : all) try {
      edits.set(edit.path, edit.attribute, edit.value);
    } catch (const ComponentError& error) {
      Problem problem;
      problem.severity = Severity::warning, problem.path = edit.path;
      problem.message = fmt::format("{}.{} keeps the value of the scene: {}", edit.path, edit.attribute, error.what());
      diagnostics.add(std::move(problem));
    }
}

}  // namespace

void Simulation::swapScene(Simulation& other) {
  std::swap(scene_, other.scene_);
  std::swap(systems_, other.systems_);
  std::swap(histories_, other.histories_);
  fault_watches_.swap(other.fault_watches_);
  std::swap(snapshots_, other.snapshots_);
  std::swap(watch_, other.watch_);
}

void Simulation::become(std::unique_ptr<Simulation> changed, Archive values) {
  end();
  const Archive start = checkpoint();
  const std::vector<Override> edited = edits();
  const std::vector<Observer*> before = observers_.all();
  const std::vector<Observer*> own = inTree(before, root()), after = successors(before, root(), changed->observers());
  const std::vector<RunEvent> events = log_.events();
  const bool worked_on = watch_.isWorkedOn();
  std::vector<std::pair<PhaseTimes, PhaseCounts>> spent;
  for (const auto& system : systems_) spent.emplace_back(system->times, system->counts);
  bool is_swapped = false;
  try {
    edits_.takeBack();  // what they changed is changed here, not in the other tree
    swapScene(*changed);
    is_swapped = true;
    observers_.replaceBy(after);
    take(std::move(values));
  } catch (...) {
    std::string not_put_back;
    const std::string why = errorSentence();
    try {
      if (is_swapped) edits_.takeBack();
    } catch (...) {
      not_put_back = errorSentence();
    }
    if (is_swapped) swapScene(*changed);
    observers_.replaceBy(before);
    try {
      take(start.readable());
    } catch (...) {
      not_put_back = errorSentence();
    }
    log_.replaceBy(events);
    for (std::size_t i = 0; i < systems_.size(); ++i) std::tie(systems_[i]->times, systems_[i]->counts) = spent[i];
    if (!not_put_back.empty())
      throw std::runtime_error(
          fmt::format("{}; and the run could not be put back ({}): load the scene again", why, not_put_back));
    throw;
  }
  log_.replaceBy(events);
  if (worked_on) watch_.noteWork();
  for (std::size_t i = 0; i < std::min(systems_.size(), spent.size()); ++i)
    std::tie(systems_[i]->times, systems_[i]->counts) = spent[i];
  if (first_) return;
  first_ = std::move(changed);
  first_->observers_.replaceBy(own);
  setAll(first_->edits_, edited, first_->scene_.diagnostics);  // reset() finds them there
}

void Simulation::becomeFirst() {
  const std::vector<Observer*> first = successors(observers_.all(), root(), first_->observers());
  // those made after a change, and what a change had written by itself
  const std::vector<Override> later = edits();
  std::vector<Override> all = first_->edits();
  std::erase_if(all, [&later](const Override& edit) {
    return std::any_of(later.begin(), later.end(), [&edit](const Override& other) {
      return other.path == edit.path && other.attribute == edit.attribute;
    });
  });
  all.insert(all.end(), later.begin(), later.end());
  first_->edits_.takeBack();
  edits_.takeBack();
  swapScene(*first_);
  observers_.replaceBy(first);
  first_.reset();
  setAll(edits_, all, scene_.diagnostics);
}

}  // namespace stroma
