// SPDX-License-Identifier: LGPL-2.1-or-later
// What masses mean in SOFA, and what becomes of states that have none.
#include <algorithm>
#include <cstdlib>
#include <set>

#include "tools/sofa/rewriting.h"

namespace stroma::sofa {
namespace {

/// The state of a mass may put the nodes of a grid elsewhere, so that its cells are no boxes: by its own positions, or by its parents'.
bool placesNodes(const Element& mass) {
  const Element* state = mass.place->nearest("mechanical state");
  if (!state || state->place->has("mapping")) return true;
  const auto gives = [state](const char* name) { return state->find(name) != nullptr; };
  return gives("position") || gives("rest_position") || gives("src") || gives("filename");
}

}  // namespace

void Rewriting::meanMass(Element& element) {
  addToOthers(element);
  const std::string& type = element.written->type;
  if (element.text("filename") == "unused") element.remove("filename");
  const bool total = element.find("totalMass"), vertex = element.find("vertexMass");
  const Element* state = element.place->nearest("mechanical state");
  const bool of_frames = state && state->text("template").starts_with("Rigid3");
  if (type == "UniformMass" && of_frames) setQuirk(element, "fixed-inertia", "turns", "false");
  if (type == "UniformMass" && state && !of_frames && element.find("filename")) {
    warn(element.written->where, element, "filename", "is read in SOFA for rigid frames only: it has no effect");
    element.remove("filename");
  }
  if (type == "UniformMass" && of_frames && total && vertex) shareMass(element, *state);
  if (type == "UniformMass" && total && vertex && !of_frames && quirks_.use("total-mass", element.path())) {
    warn(element.written->where, element, "vertexMass", "totalMass is given too and wins");
    element.remove("vertexMass");
  }
  if (state && isAnyOf(state->text("template").substr(0, 4), {"Vec1", "Vec6"})) warnOfWeight(element, *state);
  if (state && state->text("template").starts_with("Vec1") && !element.find("geometryState"))  // values of nodes that lie elsewhere
    for (const Place* place = state->place->parent; place; place = place->parent) {
      Element* points = place->firstOf("mechanical state");
      if (!points || !(points->text("template").empty() || points->text("template").starts_with("Vec3"))) continue;
      setDefault(element, "geometryState", SceneTree::linkTo(*points));
      break;
    }
  if (saysYes(element.text("separateGravity")))
    warn(element.written->where, element, "separateGravity",
         "is not followed: SOFA adds gravity to velocities after positions have moved, and this is a force in the step");
  meanLists(element);
  setDefault(element, "cells", "first"), setDefault(element, "absoluteVolumes", "true");
  const bool couples =
      (type == "MeshMatrixMass" && !saysYes(element.text("lumping"))) || type == "FEMMass" || element.place->has("mapping");
  if (couples && movesNodes()) setQuirk(element, "moved-inertia", "movedAlone", "true");
  if (type == "MeshMatrixMass") setQuirk(element, "edge-mass", "matrix", "edges");
  const Element* mesh = isAnyOf(type, {"DiagonalMass", "MeshMatrixMass"}) ? meshOf(element) : nullptr;
  const bool are_boxes = mesh && isAnyOf(mesh->written->type, {"RegularGridTopology", "SparseGridTopology"}) && !placesNodes(element);
  if (mesh && !are_boxes && mayLoadQuads(element)) setQuirk(element, "edge-mass", "shares", "equal");
}

/// Lists of masses and densities: how many numbers SOFA takes of them.
void Rewriting::meanLists(Element& mass) {
  const bool is_sparse = mass.is("MeshMatrixMass");
  const Element* state = mass.place->nearest("mechanical state");
  const bool of_points = state && (state->text("template").empty() || state->text("template").starts_with("Vec"));
  const std::vector<double> masses = writtenNumbers(mass.text("vertexMass"));
  if (mass.is("UniformMass") && of_points && mass.writes("vertexMass") && masses.size() > 1) {
    warn(mass.find("vertexMass")->where, mass, "vertexMass", "is one number in SOFA, which reads the first of these");
    mass.set("vertexMass", printReal(masses[0]));
  }
  if (!is_sparse && !mass.is("DiagonalMass")) return;
  const std::vector<double> densities = writtenNumbers(mass.text("massDensity"));
  if (!is_sparse) setDefault(mass, "lastForOthers", "true");
  if (!is_sparse && mass.writes("massDensity") && densities.size() > 1) {
    warn(mass.find("massDensity")->where, mass, "massDensity", "is one number in SOFA, which reads the first of these");
    mass.set("massDensity", printReal(densities[0]));
  }
  const AttributeDescription* given = mass.find("vertexMass");
  if (!is_sparse || !given || mass.find("totalMass") || mass.find("massDensity")) return;
  const bool couples = mass.find("edgeMass"), is_one = mass.writes("vertexMass") && masses.size() == 1;
  if (!is_one && (couples || saysYes(mass.text("lumping")))) return;
  warn(given->where, mass, "vertexMass",
       std::string(is_one ? "is one number, and SOFA asks for one for each node" : "without lumping or edgeMass does not count in SOFA") +
           ": the total mass is 1, as there",
       is_one ? "" : "lumping=\"true\"");
  mass.remove("vertexMass"), mass.remove("edgeMass");
  mass.set("totalMass", "1");
}

/// SOFA's explicit steps divide forces by the mass of each state itself. What follows it has a weight, and no inertia.
void Rewriting::leaveOutInertia() {
  std::vector<Element*> masses;
  tree_->forEach([&](Element& mass) {
    const Element* integrator = mass.place->nearest("integrator");
    const Element* state = mass.place->nearest("mechanical state");
    const bool of_points = state && (state->text("template").empty() || state->text("template").starts_with("Vec3"));
    const bool is_explicit =
        integrator && isAnyOf(integrator->written->type,
                              {"EulerExplicitSolver", "RungeKutta2Solver", "RungeKutta4Solver", "CentralDifferenceSolver"});
    if (!mass.dropped && mass.is("UniformMass") && is_explicit && of_points && isMapped(*state) && state->place == mass.place)
      masses.push_back(&mass);
  });
  for (Element* mass : masses) {
    const bool is_total = mass->find("totalMass") || !mass->find("vertexMass");
    const std::vector<double> sizes = writtenNumbers(is_total ? mass->text("totalMass") : mass->text("vertexMass"));
    const bool is_given = mass->find("totalMass") || mass->find("vertexMass");
    const bool is_chosen = mass->find("indices") || mass->find("localRange");
    if ((is_given && sizes.empty()) || is_chosen || !quirks_.use("moved-inertia", mass->path())) continue;
    std::vector<double> weight = {0, -9.81, 0};
    for (const Place* place = mass->place; place; place = place->parent)
      if (const AttributeDescription* gravity = place->node->find("gravity")) {
        weight = writtenNumbers(gravity->value);
        break;
      }
    if (weight.size() != 3) continue;
    for (double& each : weight) each *= is_given ? sizes[0] : 1;
    const SourceLocation where = mass->written->where;
    diagnostics_.note(where, mass->path(), "is a weight without inertia in explicit steps, as in SOFA");
    mass->dropped = true;
    tree_->add(*mass->place, {"ConstantForceField",
                              {{"name", mass->name + "_weight", where},
                               {"emptyMeansAll", "true", where},
                               {is_total ? "totalForce" : "force", printed(weight), where}},
                              where, mass->written->folder});
  }
}

/// A second mass of a state has to name it here.
void Rewriting::addToOthers(Element& mass) {
  Element* state = mass.place->nearest("mechanical state");
  if (!state || mass.find("mstate")) return;
  const auto acts = [&](const Element& other) {
    return other.role() == "mass" && !other.without_effect && !other.find("mstate") && other.place->nearest("mechanical state") == state;
  };
  const Element* first = nullptr;
  tree_->forEach([&](Element& other) {
    if (!first && acts(other)) first = &other;
  });
  const std::vector<ComponentDescription>& added = state->place->added_components;  // of fields that are a mass too
  const bool is_split = std::any_of(added.begin(), added.end(), [](const auto& each) { return each.type.ends_with("Mass"); });
  if (first != &mass || is_split) setQuirk(mass, "added-masses", "mstate", SceneTree::linkTo(*state));
}

/// Numbers have a mass in SOFA that the first components of gravity pull.
void Rewriting::warnOfWeight(const Element& mass, const Element& state) {
  const std::size_t most = std::size_t(state.text("template")[3] - '0');
  const auto pull = [most](const std::string& gravity) {
    const std::vector<double> numbers = writtenNumbers(gravity);
    return std::any_of(numbers.begin(), numbers.begin() + std::ptrdiff_t(std::min(most, numbers.size())), [](double g) { return g != 0; });
  };
  const auto given = std::find_if(scene_.root.attributes.begin(), scene_.root.attributes.end(),
                                  [](const AttributeDescription& attribute) { return attribute.name == "gravity"; });
  bool pulls = given != scene_.root.attributes.end() && pull(given->value);
  tree_->forEach([&](Element& each) { pulls = pulls || (each.is("Gravity") && pull(each.text("gravity"))); });
  if (pulls)
    warn(mass.written->where, mass, {}, "SOFA's numbers have a weight, mass times the first components of gravity: here they have none",
         "a ConstantForceField of that weight");
}

/// The mass of all frames together wins over that of each, which keeps its inertia per mass.
void Rewriting::shareMass(Element& mass, const Element& state) {
  std::string text = mass.text("vertexMass");
  std::replace_if(text.begin(), text.end(), [](char c) { return c == '[' || c == ']' || c == ','; }, ' ');
  std::vector<double> numbers = writtenNumbers(text);
  const std::string position = state.text("position");
  const bool is_chosen = mass.find("indices") || mass.find("localRange") || state.find("size") || state.find("src");
  if (numbers.empty() || is_chosen || position.find('@') != std::string::npos || !quirks_.use("total-mass", mass.path())) return;
  constexpr std::size_t width = 7;
  const std::size_t frames = std::max<std::size_t>(1, writtenNumbers(position).size() / width);
  warn(mass.written->where, mass, "vertexMass", "totalMass is given too and wins");
  numbers[0] = std::atof(mass.text("totalMass").c_str()) / double(frames);
  mass.set("vertexMass", printed(numbers));
  mass.remove("totalMass");
}

/// A force field, and a mass, whose cells are filled unevenly: the sparse grid counts the parts that it asks for.
void Rewriting::fillParts(Element& field) {
  const int levels = std::atoi(field.text("nbVirtualFinerLevels").c_str());
  Element* mesh = meshOf(field);
  if (!mesh || !mesh->written->type.starts_with("SparseGrid")) {
    warn(field.written->where, field, "topology", "is no sparse grid, which SOFA asks for: its cells are full");
  } else {
    const int most = std::atoi(mesh->text("nbVirtualFinerLevels").c_str());
    if (levels > most)
      warn(field.written->where, field, "nbVirtualFinerLevels",
           mesh->path() + " has " + std::to_string(most) + " finer levels: they are taken");
    constexpr int finest = 4;  // of partLevels
    if (std::min(levels, most) > finest)
      warn(field.written->where, field, "nbVirtualFinerLevels",
           "parts of " + std::to_string(finest) + " levels are taken: each has the mean stiffness of what is finer");
    const std::string asked = std::to_string(std::min({levels, most, finest})), other = mesh->text("partLevels");
    if (!other.empty() && other != asked)
      warn(field.written->where, field, "nbVirtualFinerLevels",
           "is " + asked + ", and another field on " + mesh->path() + " asks for " + other + ": both get " + asked +
               " here, where each has its own in SOFA");
    mesh->set("partLevels", asked);
    field.set("partFactors", SceneTree::linkTo(*mesh) + ".partFactors");
  }
  const bool is_mass = !saysNo(field.text("useMass"));
  if (field.written->type.starts_with("HexahedronComposite")) {
    if (is_mass && levels > 0)
      warn(field.written->where, field, {},
           "SOFA's masses follow the weights of its parts too: here they are shared out as the cells' shape functions do");
    if (saysYes(field.text("finestToCoarse")))
      warn(field.written->where, field, "finestToCoarse", "SOFA takes all levels at once then: here one after another yields");
  }
  for (const char* read : {"nbVirtualFinerLevels", "useMass"}) field.remove(read);
  if (is_mass) return splitMass(field);
  for (const char* of_mass : {"density", "lumpedMass", "rayleighMass", "massMatrices", "totalMass"}) field.remove(of_mass);
}

/// A field of voxels on several levels, which are one until cells are cut out.
void Rewriting::meanVoxels(Element& field) {
  const Element* mesh = meshOf(field);
  const std::string level = mesh ? mesh->text("level") : "";
  if (std::atoi(level.c_str()) != 0)
    diagnostics_.error(mesh->find("level")->where, mesh->path() + ".level",
                       "cells of several voxels, whose stiffness " + field.path() + " sums up in SOFA, are not available here", "0");
  for (const char* of_sums : {"recursive", "useMBK"}) field.remove(of_sums);
}

/// Some constraint puts nodes where they are to be.
bool Rewriting::movesNodes() const {
  static const std::vector<std::string_view> still = {"Fixed", "PartialFixed", "FixedTranslation", "FixedRotation", "FixedPlane"};
  bool moves = false;
  tree_->forEach([&moves](Element& element) {
    if (element.role() != "projective constraint") return;
    moves = moves || std::none_of(still.begin(), still.end(), [&element](std::string_view word) {
      return element.written->type == std::string(word) + "ProjectiveConstraint";
    });
  });
  return moves;
}

/// Below an integrator a state without mass, on which nothing acts, stays where it is: a target that a program moves. Here
/// it gets a mass that nothing pulls. Where stiffness alone moves it the integrator has to allow that.
void Rewriting::holdMassless(Place& place, bool is_moved) {
  const bool moves = is_moved || place.has("integrator");
  Element* state = place.firstOf("mechanical state");
  const bool is_held = std::any_of(place.elements.begin(), place.elements.end(),  // by rewritten_bodies.cpp
                                   [](const auto& each) { return each->name.starts_with("held_by_the_scene_"); });
  if (moves && state && !is_held && !isMapped(*state) && !hasMass(place) && !isPulledFromElsewhere(*state, "mass") &&
      !isPulledThroughOthers(*state)) {
    const bool pulled = actsIn(place, {"force field", "position constraint"}) || isPulledFromElsewhere(*state, "");
    const Element* integrator = place.nearest("integrator");
    // others begin with an acceleration, or swing
    const bool takes_it = integrator && integrator->is("EulerImplicitSolver") && !saysYes(integrator->text("trapezoidalScheme"));
    const SourceLocation& where = state->written->where;
    if (pulled && takes_it) diagnostics_.note(where, state->path(), "has no mass: stiffness alone moves it");
    if (!pulled && !actsIn(place, {"projective constraint"})) {
      NodeDescription weightless;  // a node of its own: gravity is that of what else is here
      weightless.where = where;
      weightless.folder = state->written->folder;
      weightless.attributes = {{"name", state->name + "_mass", where}, {"gravity", "0 0 0", where}};
      weightless.components.push_back(
          {"UniformMass",
           {{"totalMass", "1", where}, {"mstate", SceneTree::linkTo(*state), where}},
           where,
           state->written->folder});
      place.added_children.push_back(std::move(weightless));
      diagnostics_.note(where, state->path(), "has no mass, and nothing acts on it: it stays where it is");
    }
  }
  for (const auto& child : place.children)
    if (!child->dropped) holdMassless(*child, moves);
}

/// Nodes that follow it, in another place or below, have a mass or are acted on.
bool Rewriting::isPulledThroughOthers(const Element& state) const {
  bool found = false;
  tree_->forEach([&](Element& element) {
    if (element.role() != "mapping" || !actsIn(*element.place, {"force field", "mass", "position constraint"})) return;
    bool is_named = false;
    for (const char* name : {"input", "input1", "input2"}) {
      const AttributeDescription* given = element.find(name);
      if (!given) continue;
      is_named = true;
      forLinks(*given, [&](std::string_view link) {
        const LinkTarget target = tree_->follow(element, link, false);
        found = found || target.element == &state || (!target.element && target.place == state.place);
      });
    }
    const Place* above = element.place->parent;
    found = found || (!is_named && above && above->nearest("mechanical state") == &state);
  });
  return found;
}

/// A body of its own, below another one.
static bool isOther(const Place& place) { return place.has("mechanical state") && !place.has("mapping"); }

/// In the place or below, but for other bodies.
bool Rewriting::hasMass(const Place& place) const {
  const auto is_mass = [](const ComponentDescription& each) { return each.type.ends_with("Mass"); };  // split off a field
  const auto weighs_beams = [](const auto& each) {
    return each->is("AdaptiveBeamForceFieldAndMass") && !each->dropped && !saysNo(each->text("computeMass"));
  };
  return place.has("mass") || std::any_of(place.elements.begin(), place.elements.end(), weighs_beams) ||
         std::any_of(place.added_components.begin(), place.added_components.end(), is_mass) ||
         std::any_of(place.children.begin(), place.children.end(),
                     [this](const auto& child) { return !child->dropped && !isOther(*child) && hasMass(*child); });
}
bool Rewriting::actsIn(const Place& place, const std::set<std::string>& roles) const {
  return std::any_of(place.elements.begin(), place.elements.end(),
                     [&roles](const auto& each) { return !each->dropped && roles.count(each->role()); }) ||
         std::any_of(place.children.begin(), place.children.end(),
                     [&](const auto& child) { return !child->dropped && !isOther(*child) && actsIn(*child, roles); });
}

}  // namespace stroma::sofa
