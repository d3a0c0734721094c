// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that change while a simulation runs.
#include "framework/simulation/run_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <list>

#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "tools/platform/error_sentence.h"

namespace stroma {
namespace {

/// Whether something of a system is in `top` or below.
bool isPartlyBelow(const System& system, const Node& top) {
  const auto is_below = [&top](const Component* component) {
    const Node* node = &component->node();
    while (node && node != &top) node = node->parent();
    return node != nullptr;
  };
  return std::any_of(system.components().begin(), system.components().end(), is_below);
}

/// What a system may make use of: its components, and what they name by links, and so on.
std::vector<Component*> withinReach(const System& system) {
  std::vector<Component*> found = system.components();
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const Data& attribute : found[i]->data().all()) {
      Component* target = attribute.link() ? attribute.link()->target() : nullptr;
      if (target && std::find(found.begin(), found.end(), target) == found.end()) found.push_back(target);
    }
  return found;
}

/// True when an edit may change something for a system. Components also find others in the nodes above their own.
bool reaches(const LiveEdit& edit, const System& system) {
  if (edit.node()) return isPartlyBelow(system, *edit.node());
  const std::vector<Component*> near = withinReach(system);
  const auto matters = [&](Component* component) {
    return isPartlyBelow(system, component->node()) || std::find(near.begin(), near.end(), component) != near.end();
  };
  return matters(edit.component()) || std::any_of(edit.recompiled().begin(), edit.recompiled().end(), matters);
}

/// The state of the components, around a change that recompiles some of them.
class KeptMemory {
 public:
  explicit KeptMemory(std::vector<Component*> components) : components_(std::move(components)) {
    std::sort(components_.begin(), components_.end());
    components_.erase(std::unique(components_.begin(), components_.end()), components_.end());
    for (Component* component : components_) visit(*component);
  }
  void giveBack() {
    archive_ = archive_.readable();  // from its start, also when it is given back twice
    for (Component* component : components_) {
      try {
        visit(*component);
      } catch (const std::runtime_error&) {  // the archive speaks of checkpoints
        throw ComponentError(component->path() + " remembers the steps so far in another size than it would now have",
                             "a value that leaves its size");
      }
    }
  }

 private:
  void visit(Component& component) {
    archive_.enter(component.path());
    component.serialize(archive_);
  }
  std::vector<Component*> components_;
  Archive archive_;
};

/// In a catch clause: the error as one of the attribute, which says what has become of it.
[[noreturn]] void throwAgain(const LiveEdit& edit) {
  const std::string kept = "; " + edit.name() + " keeps its old value";
  try {
    throw;
  } catch (const ComponentError& error) {
    throw ComponentError(error.what() + kept, error.expected, error.suggestion);
  } catch (const std::exception& error) {
    throw ComponentError(edit.name() + " cannot change: " + error.what() + kept);
  }
}

}  // namespace

RunEdits::RunEdits(const std::unique_ptr<Node>& root, const Systems& systems, Snapshots& snapshots, RunClock& clock, RunLog& log,
                   RunWatch& watch)
    : root_(root), systems_(systems), snapshots_(snapshots), clock_(clock), log_(log), watch_(watch) {}

void RunEdits::check(const LiveEdit& edit) const {
  for (const auto& system : systems_) {
    // coupled integrators that are not alike would be refused when the changed scene is loaded again
    for (const MergedIntegrator& merged : system->merged()) {
      const Component* const own[] = {&system->integrator(), merged.integrator};
      const Component* const solvers[] = {system->linearSolver(), merged.integrator->linearSolver()};
      const bool is_shared = solvers[0] == solvers[1];
      const auto isEdited = [&edit](const Component* each) { return edit.component() && edit.component() == each; };
      if (std::any_of(std::begin(own), std::end(own), isEdited) ||
          (!is_shared && std::any_of(std::begin(solvers), std::end(solvers), isEdited)))
        throw LiveEdit::NeedsLoad(
            fmt::format("{} cannot change while the scene runs: {} couples the bodies of {} and {}, "
                        "integrators that must stay alike",
                        edit.name(), merged.because, merged.integrator->path(), system->integrator().path()),
            "one integrator in a node above both bodies", "load the scene again with the new value for both");
    }
    if (!system->integrator().stateOwner()) continue;
    const std::vector<Component*>& own = system->components();
    const auto inside = [&own](const Component* component) {
      return std::find(own.begin(), own.end(), component) != own.end();
    };
    if (!edit.component() || inside(edit.component()) ||
        std::any_of(edit.recompiled().begin(), edit.recompiled().end(), inside))
      throw LiveEdit::NeedsLoad(edit.name() + " cannot change while the scene runs: " + system->integrator().path() +
                                    " has computed its matrix and loads beforehand",
                                "an integrator that makes its matrix in steps",
                                "load the scene again with the new value (--set " + edit.name() + "=...)");
  }
}

Diagnostics RunEdits::set(const std::string& path, const std::string& attribute, const std::string& text) {
  LiveEdit edit(*root_, path, attribute);
  check(edit);
  complete(systems_);
  Diagnostics messages;
  const LiveEdit::Value before = edit.value();
  change(edit, {text}, messages);
  if (edit.changesTimeStep()) clock_.countFromHere();
  watch_.noteWork();
  const auto known = std::find_if(edits_.begin(), edits_.end(), [&](const Edit& other) {
    return other.path == path && other.attribute == attribute;
  });
  Edit noted{path, attribute, before.text, text, before.origin};
  if (known != edits_.end()) {
    noted.original = known->original, noted.origin = known->origin;
    edits_.erase(known);
  }
  edits_.push_back(std::move(noted));
  log_.record(clock_.steps(), AttributeEdit{path, attribute, text});
  return messages;
}

void RunEdits::change(LiveEdit& edit, const LiveEdit::Value& value, Diagnostics& messages) {
  const LiveEdit::Value before = edit.value();
  snapshots_.takeGood(systems_);
  std::vector<System*> concerned;
  for (const auto& system : systems_)
    if (!system->integrator().stateOwner() && reaches(edit, *system)) concerned.push_back(system.get());
  std::vector<Component*> remembering = edit.recompiled();
  for (const System* system : concerned) remembering.push_back(&system->integrator());
  KeptMemory kept(std::move(remembering));
  const auto put = [&](const LiveEdit::Value& wanted, Diagnostics& told) {
    edit.apply(wanted, told);
    std::list<LiveEdit::Listener> listeners;
    for (Component* component : edit.recompiled()) listeners.emplace_back(*component, told);
    for (System* system : concerned) {
      const LiveEdit::Listener listener(system->integrator(), told);
      if (edit.changesTimeStep()) system->integrator().compile(*system);
      if (edit.changesGravity()) system->gravityChanged();
      if (!edit.recompiled().empty()) system->componentsChanged(edit.recompiled(), clock_.time());
    }
    kept.giveBack();
    for (const System* system : concerned) system->integrator().sceneChanged();
  };
  try {
    put(value, messages);
  } catch (...) {
    std::string not_put_back;
    try {
      Diagnostics told_before;
      put(before, told_before);
    } catch (...) {
      not_put_back = errorSentence();
    }
    snapshots_.putGoodBack(systems_, systems_.size());
    if (!not_put_back.empty())
      throw ComponentError(
          edit.name() + " could neither be changed (" + errorSentence() + ") nor be put back (" + not_put_back + ")",
          {}, "load the scene again");
    throwAgain(edit);
  }
}

std::vector<Override> RunEdits::all() const {
  std::vector<Override> all;
  for (const Edit& edit : edits_) all.push_back({edit.path, edit.attribute, edit.text});
  return all;
}

void RunEdits::takeBack() {
  for (auto edit = edits_.rbegin(); edit != edits_.rend(); ++edit) {
    LiveEdit live(*root_, edit->path, edit->attribute);
    Diagnostics told_before;
    change(live, {edit->original, edit->origin}, told_before);
  }
  edits_.clear();
}

void visitEdits(Archive& archive, std::vector<Override>& edits) {
  std::size_t count = edits.size();
  archive.value("count", count);
  edits.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i) + " ";
    archive.value(number + "path", edits[i].path);
    archive.value(number + "attribute", edits[i].attribute);
    archive.value(number + "text", edits[i].value);
  }
}

void RunEdits::serialize(Archive& archive) {
  archive.enter("edits");
  std::vector<Override> stored = all();
  visitEdits(archive, stored);
  if (!archive.isReading()) return;
  takeBack();
  for (const Override& edit : stored) set(edit.path, edit.attribute, edit.value);
}

}  // namespace stroma
