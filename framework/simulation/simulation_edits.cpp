// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that change while a simulation runs.
#include <algorithm>

#include "framework/scene/live_edit.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

/// An integrator that has computed its matrix beforehand follows no change of what the matrix was made of.
void refuseWhatWasPrecomputed(const LiveEdit& edit, const std::vector<std::unique_ptr<System>>& systems) {
  for (const auto& system : systems) {
    if (system->integrator().followsChanges()) continue;
    const auto isInside = [&system](const Component* component) {
      for (const Node* node = &component->node(); node; node = node->parent())
        if (node == &system->node()) return true;
      return false;
    };
    if (!edit.component() || isInside(edit.component()) ||
        std::any_of(edit.recompiled().begin(), edit.recompiled().end(), isInside))
      throw ComponentError(edit.name() + " cannot change while the scene runs: " + system->integrator().path() +
                               " has computed its matrix and loads beforehand",
                           "an integrator that makes its matrix in steps",
                           "load the scene again with the new value (--set " + edit.name() + "=...)");
  }
}

/// What the components remember, around a change that makes some anew.
class KeptMemory {
 public:
  explicit KeptMemory(std::vector<Component*> components) : components_(std::move(components)) {
    std::sort(components_.begin(), components_.end());
    components_.erase(std::unique(components_.begin(), components_.end()), components_.end());
    visit();
  }
  void giveBack() {
    archive_ = archive_.readable();  // from its start, also when it is given back twice
    visit();
  }

 private:
  void visit() {
    for (Component* component : components_) {
      archive_.enter(component->path());
      component->serialize(archive_);
    }
  }
  std::vector<Component*> components_;
  Archive archive_;
};

}  // namespace

Diagnostics Simulation::setAttribute(const std::string& path, const std::string& attribute, const std::string& text) {
  LiveEdit edit(root(), path, attribute);
  refuseWhatWasPrecomputed(edit, systems_);
  complete();
  const std::string before = edit.print();
  std::vector<Component*> remembering = edit.recompiled();
  for (const auto& system : systems_) remembering.push_back(&system->integrator());
  KeptMemory kept(std::move(remembering));
  Diagnostics messages;
  const auto compileAgain = [&] {
    for (const auto& system : systems_) {
      if (!system->integrator().followsChanges()) continue;
      LiveEdit::listen(system->integrator(), &messages);
      system->componentsChanged(edit.recompiled(), time_);
      LiveEdit::listen(system->integrator(), nullptr);
    }
    kept.giveBack();
  };
  try {
    edit.apply(text, messages);
    compileAgain();
  } catch (const ComponentError&) {
    edit.revert();
    compileAgain();
    throw;
  }
  if (edit.changesTimeStep()) countFromHere();
  worked_on_ = true;
  const auto known = std::find_if(edits_.begin(), edits_.end(), [&](const Edit& other) {
    return other.path == path && other.attribute == attribute;
  });
  if (known != edits_.end()) {
    known->text = text;
  } else {
    edits_.push_back({path, attribute, before, text});
  }
  return messages;
}

/// Reading: attributes get the values that they had when the checkpoint was written.
void Simulation::serializeEdits(Archive& archive) {
  archive.enter("edits");
  std::size_t count = edits_.size();
  archive.value("count", count);
  const std::vector<Edit> present = edits_;
  std::vector<Edit> stored = edits_;
  stored.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i) + " ";
    archive.value(number + "path", stored[i].path);
    archive.value(number + "attribute", stored[i].attribute);
    archive.value(number + "original", stored[i].original);
    archive.value(number + "text", stored[i].text);
  }
  if (!archive.isReading()) return;
  for (const Edit& edit : present) setAttribute(edit.path, edit.attribute, edit.original);
  for (const Edit& edit : stored) setAttribute(edit.path, edit.attribute, edit.text);
  for (Edit& edit : stored) {
    const auto had = std::find_if(present.begin(), present.end(), [&](const Edit& other) {
      return other.path == edit.path && other.attribute == edit.attribute;
    });
    if (had != present.end()) edit.original = had->original;
  }
  edits_ = std::move(stored);
}

}  // namespace stroma
