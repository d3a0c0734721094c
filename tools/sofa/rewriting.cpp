// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sofa/rewriting.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/text.h"

namespace stroma {

bool isForeign(const std::string& file, const NodeDescription& root, const std::vector<Override>& overrides) {
  for (const Override& change : overrides)
    if (change.attribute == "dialect") return trimmed(change.value) == foreign_dialect;
  if (const AttributeDescription* dialect = root.find("dialect")) return trimmed(dialect->value) == foreign_dialect;
  return file.ends_with(".scn");
}

bool isPrefabAbroad(const std::string& type) {
  if (type == "PlaneConstraint") return true;  // SOFA has no component of this name
  const auto& removals = typeRemovals();
  return std::any_of(removals.begin(), removals.end(), [&](const TypeRemoval& each) { return each.type == type; });
}

void rewriteForeign(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
                    std::vector<std::string>& no_effect) {
  sofa::Rewriting(scene, factory, modules, diagnostics, no_effect).run();
}

namespace sofa {

Rewriting::Rewriting(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
                     std::vector<std::string>& no_effect)
    : scene_(scene), factory_(factory), modules_(modules), diagnostics_(diagnostics), no_effect_(no_effect) {}

void Rewriting::run() {
  readSwitches();
  if (!is_foreign_) return;
  addFoldersOfTree();
  moveJoints(scene_.root);
  resolveAliases();
  expandPrefabs();
  expandSolids();
  tree_ = std::make_unique<SceneTree>(scene_.root, [this](const std::string& type) -> std::unique_ptr<Component> {
    try {
      const std::string here(typeHere(type));
      return modules_.provide(here) ? factory_.make(here) : nullptr;
    } catch (const std::runtime_error&) {
      return nullptr;  // a module that cannot be opened is reported when the component is made
    }
  });
  tree_->forEachPlace([this](Place& place) { rewriteNode(place); });
  acceptTypes();
  makeChains();
  liftPlanes();
  divideSteps();
  matchShapes();
  dropVisualMappings();
  dropVoids();
  dropUnheard();
  dropIdleMappings();
  dampVelocities();
  keepOneIntegrator(tree_->root(), false);
  joinBodies();
  dropIdle(tree_->root(), false);
  leaveOutInertia();
  holdMassless(tree_->root(), false);
  chooseSolvers();
  dropUnusedSolvers();
  dropIdleEngines();
  findNodesOfRegions();
  dropUnusedLoaders();
  dropIdleWatch();
  tree_->forEach([this](Element& element) { rewriteLinks(element); });
  for (Element* region : parts_) renumberPart(*region);
  tree_->forEach([this](Element& element) {
    readMeshFiles(element);
    readOwnFile(element);
    if (element.written->type.starts_with("SparseGrid") || element.is("CubeTopology")) joinCorners(element);
    if (element.is("MeshSpringForceField") || element.is("RegularGridSpringForceField") || element.is("QuadBendingSprings"))
      checkOneBody(element);
  });
  takeExternalForces();
  tree_->forEach([this](Element& element) { rewriteAttributes(element); });
  tree_->forEach([this](Element& element) { applyMeaning(element); });
  addSweeps(), tree_->finish();
  std::string ways;
  for (const std::string& line : quirks_.lines()) ways += (ways.empty() ? "" : "; ") + line;
  diagnostics_.note(scene_.root.where, dialect_note,
                    ways.empty() ? "in SOFA's dialect; none of SOFA's own ways matters here"
                                 : "in SOFA's dialect, with its ways (--without-quirk NAME leaves one out): " + ways);
}

/// `dialect` and `withoutQuirks` of the outermost node are for this room alone.
void Rewriting::readSwitches() {
  std::vector<AttributeDescription>& attributes = scene_.root.attributes;
  const AttributeDescription* dialect = scene_.root.find(dialect_attribute);
  is_foreign_ = dialect && trimmed(dialect->value) == foreign_dialect;
  for (const AttributeDescription& attribute : attributes) {
    if (attribute.name == "dialect" && trimmed(attribute.value) != foreign_dialect && trimmed(attribute.value) != "native")
      diagnostics_.error(attribute.where, "/.dialect", inQuotes(attribute.value) + " is no dialect", "sofa or native",
                         nearest(attribute.value, {"sofa", "native"}));
    if (attribute.name != "withoutQuirks") continue;
    Words words(attribute.value);
    for (std::string name(words.next()); !name.empty(); name = words.next()) {
      const std::vector<std::string> names = quirkNames();
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        std::string expected = "one of:";
        for (const std::string& each : names) expected += (each == names[0] ? " " : ", ") + each;
        diagnostics_.error(attribute.where, "/.withoutQuirks", "there is no quirk " + inQuotes(name), expected,
                           nearest(name, names));
      }
      quirks_.switchOff(name);
    }
    if (!is_foreign_)
      diagnostics_.error(attribute.where, "/.withoutQuirks", "only a scene in SOFA's dialect has its quirks",
                         "dialect=\"sofa\" beside it");
  }
  std::erase_if(attributes, [](const AttributeDescription& attribute) {
    return attribute.name == "dialect" || attribute.name == "withoutQuirks";
  });
}

// ---- nodes ----

/// What SOFA has of a number of a node that it cannot read; empty: it can.
static std::string readOfNode(const AttributeDescription& attribute) {
  if (attribute.typed || (attribute.name != "gravity" && attribute.name != "dt")) return {};
  const bool is_step = attribute.name == "dt";
  std::istringstream numbers(attribute.value);
  double number = 0;
  for (int i = 0; i < (is_step ? 1 : 3); ++i)
    if (!(numbers >> number)) return is_step ? "0.01" : readByStream(attribute.value, "0 -9.81 0");
  return is_step && numbers.peek() == '/' ? printReal(number) : "";
}

/// SOFA says nothing of attributes that a node does not have, and gives each child the context of its parent.
void Rewriting::rewriteNode(Place& place) {
  std::vector<AttributeDescription>& attributes = place.node->attributes;
  const std::vector<std::string>& known = nodeAttributes();
  std::erase_if(attributes, [&](AttributeDescription& attribute) {
    const bool is_known = std::find(known.begin(), known.end(), attribute.name) != known.end();
    if (!is_known) return noEffect("Node." + attribute.name), true;
    if (const std::string read = readOfNode(attribute); !read.empty()) {
      diagnostics_.warning(attribute.where, place.path() + "." + attribute.name,
                           inQuotes(attribute.value) + " is no value: SOFA has " + read + " of it, and so has this scene");
      attribute.value = read;
    }
    if (!place.parent || (attribute.name != "gravity" && attribute.name != "dt")) return false;
    const std::string path = place.path() + "." + attribute.name;
    const bool drops = quirks_.use("child-gravity", path) || attribute.name == "dt";
    if (drops)
      diagnostics_.note(attribute.where, path, "does not count: a child has the " + attribute.name + " of its parent");
    return drops;
  });
  for (const auto& element : place.elements) {
    tellUnread(*element);
    if (!element->is("Gravity")) continue;
    std::erase_if(attributes, [](const AttributeDescription& attribute) { return attribute.name == "gravity"; });
    attributes.push_back({"gravity", element->find("gravity") ? element->text("gravity") : "0 0 0", element->written->where});
    element->dropped = true;
  }
  if (const AttributeDescription* activated = place.node->find("activated"); activated && saysNo(activated->value))
    place.dropped = place.parent != nullptr;
  if (place.dropped) diagnostics_.note(place.node->where, place.path(), "the node is not activated");
}

// ---- what takes no part ----

/// A system that a CompositeLinearSystem beside it fills, and that is not the one to be solved.
static bool isOneOfSeveral(const Element& system) {
  for (const auto& each : system.place->elements)
    if (each->is("CompositeLinearSystem") && each->find("solverLinearSystem"))
      return !each->text("solverLinearSystem").ends_with(system.name);
  return false;
}

void Rewriting::acceptTypes() {
  const auto& accepted = acceptedWithoutEffect();
  tree_->forEach([&](Element& element) {
    const std::string_view type = element.written->type;
    if (element.role() != "mesh loader") warnOfIgnored(element);  // those that are read are told later
    const bool is_everywhere = std::find(accepted.begin(), accepted.end(), type) != accepted.end();
    if (!element.probe && is_everywhere) element.without_effect = true, warnOfAccepted(element);
    if (element.probe || is_everywhere || !isAcceptedType(type)) {
      if (element.probe) renameType(element);
      return;
    }
    const bool is_part = element.is("MatrixLinearSystem") && isOneOfSeveral(element);
    for (const char* name : {"assembleStiffness", "assembleMass", "assembleDamping", "assembleGeometricStiffness",
                             "applyProjectiveConstraints", "applyMappedComponents"})
      if (saysNo(element.text(name)) && !is_part && !isIdleSwitch(name, element))
        diagnostics_.error(element.find(name)->where, element.path() + "." + name,
                           "a matrix without a part of it cannot be assembled here", "true");
    element.without_effect = element.dropped = true;
    noEffect(std::string(type));
    warnOfAccepted(element);
    sayWhyIdle(element);
  });
}

/// A state that somebody may move lies in the place or below.
static bool holdsState(const Place& place) {
  return place.has("mechanical state") || std::any_of(place.children.begin(), place.children.end(),
                                                      [](const auto& child) { return !child->dropped && holdsState(*child); });
}

/// A solver solves everything below its node: SOFA never asks those further down.
void Rewriting::keepOneIntegrator(Place& place, bool is_moved) {
  bool found = is_moved;
  for (const auto& element : place.elements) {
    if (element->dropped || element->role() != "integrator") continue;
    if (found || !holdsState(place)) {
      element->dropped = true;
      diagnostics_.note(element->written->where, element->path(),
                        found ? "does not count: an integrator in this node or above solves for what is here"
                              : "does not count: there is no state in this node or below");
      continue;
    }
    found = true;
  }
  for (const auto& child : place.children)
    if (!child->dropped) keepOneIntegrator(*child, found);
}

/// True for what links to states by itself: it may act elsewhere.
bool Rewriting::movesElsewhere(const Element& element) const {
  for (const char* link : {"object1", "object2", "mstate", "input", "input1", "input2"})
    if (element.find(link)) return true;
  return false;
}

/// Nothing asks for the forces on bodies that no integrator moves.
void Rewriting::dropIdle(Place& place, bool is_moved) {
  const bool moves = is_moved || place.has("integrator");
  static const std::set<std::string> acting = {"force field", "mass", "projective constraint", "position constraint"};
  for (const auto& element : place.elements) {
    if (moves || element->dropped || !acting.count(element->role())) continue;
    if (movesElsewhere(*element) || isContactAnswer(element->written->type)) continue;
    element->dropped = true;
    const std::string why = "does not count: no integrator moves anything in this node";
    if (!putsNodes(*element)) diagnostics_.note(element->written->where, element->path(), why);
    else warn(element->written->where, *element, {}, why + ", and in SOFA it moves nodes all the same", "a node for this state alone");
  }
  for (const auto& child : place.children)
    if (!child->dropped) dropIdle(*child, moves);
}

/// A component of another node acts on it: of a role, or of any.
bool Rewriting::isPulledFromElsewhere(const Element& state, std::string_view role) const {
  bool found = false;
  tree_->forEach([&](Element& element) {
    for (const char* name : {"object1", "object2", "mstate"}) {
      const bool acts = !element.dropped && !element.without_effect && element.role() != "selection" && element.role() != "engine" &&
                        (role.empty() || element.role() == role);
      const std::string link = acts ? element.text(name) : "";
      if (link.empty()) continue;
      const LinkTarget target = tree_->follow(element, link, false);
      found = found || target.element == &state || (!target.element && target.place == state.place);
    }
  });
  return found;
}

bool Rewriting::isMapped(const Element& state) const {
  bool found = false;
  tree_->forEach([&](Element& element) {
    if (element.dropped || element.role() != "mapping") return;
    const std::string output = element.text("output");
    if (output.empty()) {
      found = found || element.place == state.place;
      return;
    }
    const LinkTarget target = tree_->follow(element, output, false);
    found = found || target.element == &state || (!target.element && target.place == state.place);
  });
  return found;
}

/// A mapping onto what only draws, in a node that has no state of its own.
void Rewriting::dropVisualMappings() {
  tree_->forEach([this](Element& element) {
    if (element.role() != "mapping") return;
    bool draws = false;
    if (const std::string output = element.text("output"); !output.empty()) {
      const LinkTarget target = tree_->follow(element, output, false);
      draws = target.element ? target.element->without_effect
                             : target.place && !target.place->has("mechanical state");
    } else {
      const auto& here = element.place->elements;
      draws = !element.place->has("mechanical state") &&
              std::any_of(here.begin(), here.end(), [](const auto& each) { return each->without_effect; });
    }
    if (!draws) return;
    element.dropped = true;
    noEffect(element.written->type + " of what is drawn");
  });
}

/// Solvers where no integrator is, which nothing names.
void Rewriting::dropUnusedSolvers() {
  std::set<const Element*> named;
  tree_->forEach([&](Element& element) {
    for (const AttributeDescription& attribute : element.written->attributes)
      if (attribute.value.find('@') != std::string::npos)
        if (const LinkTarget target = tree_->follow(element, trimmed(attribute.value), false); target.element)
          named.insert(target.element);
  });
  tree_->forEach([&](Element& element) {
    if (element.role() != "linear solver" && element.role() != "Newton solver" && element.role() != "preconditioner")
      return;
    if (element.place->has("integrator") || named.count(&element)) return;
    element.dropped = true;
    noEffect(element.path());
  });
}

/// Loaders of what only draws, or of nothing: their files need not be there, and are told.
void Rewriting::dropUnusedLoaders() {
  std::set<const Element*> named;
  tree_->forEach([&](Element& element) {
    if (element.without_effect) return;
    for (const AttributeDescription& attribute : element.written->attributes)
      forLinks(attribute, [&](std::string_view word) {
        for (const bool names_data : {false, true})
          if (const LinkTarget target = tree_->follow(element, word, names_data); target.element) named.insert(target.element);
      });
  });
  tree_->forEach([&](Element& element) {
    if (element.role() != "mesh loader") return;
    if (named.count(&element)) return checkSequence(element);
    tellMissingFile(element), element.dropped = true;
    noEffect(element.path());
  });
}

/// Without an answer to contacts SOFA's pipeline changes nothing, and neither do models without a pipeline. Without models it
/// has nothing to look at.
void Rewriting::dropIdleWatch() {
  bool answers = false, can_touch = false;
  tree_->forEach([&can_touch](Element& element) { can_touch = can_touch || element.role() == "collision model"; });
  tree_->forEach([&](Element& element) {
    if (can_touch || (!element.is("CollisionPipeline") && !element.is("CollisionResponse"))) return;
    element.dropped = true;
    noEffect(element.written->type + " where nothing can touch");
  });
  tree_->forEachPlace([&](Place& place) {  // those that were accepted, which are no part any more, too
    for (const auto& element : place.elements) answers = answers || isContactAnswer(element->written->type);
  });
  if (answers) return;
  tree_->forEach([&](Element& element) {
    if (!element.is("CollisionPipeline")) return;
    element.dropped = true;
    noEffect("CollisionPipeline without an answer to contacts");
  });
}

// ---- help ----

void Rewriting::setDefault(Element& element, const std::string& attribute, const std::string& value) {
  const Data* data = element.probe ? element.probe->data().find(attribute) : nullptr;
  if (!data) return;
  for (const AttributeDescription& each : element.written->attributes)
    if (element.probe->data().find(each.name) == data) return;
  element.set(attribute, value);
}

void Rewriting::noEffect(const std::string& what) {
  if (std::find(no_effect_.begin(), no_effect_.end(), what) == no_effect_.end()) no_effect_.push_back(what);
}

void Rewriting::warn(const SourceLocation& where, const Element& element, const std::string& what, std::string message,
                     std::string suggestion) {
  diagnostics_.warning(where, element.path() + (what.empty() ? "" : "." + what), std::move(message),
                       std::move(suggestion));
}

}  // namespace sofa
}  // namespace stroma
