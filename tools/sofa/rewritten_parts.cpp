// SPDX-License-Identifier: LGPL-2.1-or-later
// Parts of a scene that become others: types under other names, force fields that are a mass too, steps of a loop that divides
// them; and of several solvers and engines those that somebody asks.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

bool hasType(const NodeDescription& node, std::string_view type) {
  return std::any_of(node.components.begin(), node.components.end(), [type](const auto& each) { return each.type == type; });
}
bool holdsType(const NodeDescription& node, std::string_view type) {
  return hasType(node, type) ||
         std::any_of(node.children.begin(), node.children.end(), [type](const auto& child) { return holdsType(child, type); });
}
bool holdsOnlyJoints(const NodeDescription& node) {
  const auto is_joint = [](const auto& each) { return each.type == "ArticulationCenter" || each.type == "Articulation"; };
  return std::all_of(node.components.begin(), node.components.end(), is_joint) &&
         std::all_of(node.children.begin(), node.children.end(), holdsOnlyJoints);
}
/// Copies the joints into the nodes whose mapping has none; false: there is no such node.
bool giveJoints(NodeDescription& node, const std::vector<NodeDescription>& joints) {
  bool gave = false;
  for (NodeDescription& child : node.children) gave = giveJoints(child, joints) || gave;
  if (!hasType(node, "ArticulatedSystemMapping") || holdsType(node, "ArticulationCenter")) return gave;
  node.children.insert(node.children.end(), joints.begin(), joints.end());
  return true;
}

}  // namespace

/// In SOFA the joints stand below an ArticulatedHierarchyContainer, beside the node of the mapping; here in that node or below.
void Rewriting::moveJoints(NodeDescription& node) {
  if (hasType(node, "ArticulatedHierarchyContainer")) {
    const auto is_joints = [](const NodeDescription& child) { return holdsType(child, "ArticulationCenter") && holdsOnlyJoints(child); };
    std::vector<NodeDescription> joints;
    std::copy_if(node.children.begin(), node.children.end(), std::back_inserter(joints), is_joints);
    if (!joints.empty() && giveJoints(node, joints)) std::erase_if(node.children, is_joints);
  }
  for (NodeDescription& child : node.children) moveJoints(child);
}

/// The type here, and what the name alone said.
void Rewriting::renameType(Element& element) {
  const std::string type = element.written->type;
  meanOfNames(element);
  if (type == "CompositeCollisionPipeline" || type == "MultiCollisionPipeline")
    warn(element.written->where, element, {}, "has pipelines for groups of models in SOFA: here all models may meet each other");
  if (Element* state = type == "AverageCoord" && !element.find("vertices") ? element.place->nearest("mechanical state") : nullptr)
    element.set("vertices", SceneTree::linkTo(*state) + ".position");
  if (type == "AsyncSparseLDLSolver")
    warn(element.written->where, element, {},
         "SOFA factors in another thread and solves with older factors: this solver has those of the step");
  if (type == "TetrahedralTensorMassForceField") element.set("method", "small");
  if (type == "CenterOfMassMulti2Mapping") {
    element.set("input", element.text("input1") + " " + element.text("input2"));
    for (const char* one : {"input1", "input2"}) element.remove(one);
  }
  if (type == "CenterPointTopologicalMapping") element.set("hexaBaryCoords", "0.5 0.5 0.5");
  if (type == "UniformVelocityDampingForceField" && saysYes(element.text("implicit"))) {
    element.remove("implicit");
    element.set("explicitDamping", "false");
  }
  if (type == "FixedWeakConstraint") {  // springs to where the nodes rest: all of them, those listed, or node 0
    if (saysYes(element.text("fixAll")))
      element.remove("indices");
    else if (!element.find("indices"))
      element.set("indices", "0");
    element.remove("fixAll");
  }
  if (type == "SubsetTopology" && saysYes(element.text("localIndices"))) parts_.push_back(&element);
  if (type == "SubsetTopology") element.remove("localIndices");
  if (type == "HexahedronFEMForceFieldAndMass" || type.ends_with("HexahedralFEMForceFieldAndMass")) splitMass(element);
  if (type.starts_with("NonUniformHexahedronFEM") || type == "HexahedronCompositeFEMForceFieldAndMass") fillParts(element);
  if (type == "HexahedronCompositeFEMMapping" && element.place->has("mechanical state"))
    warn(element.written->where, element, {}, "SOFA's points follow the parts of the cells: here they follow the cells");
  if (type == "RuleBasedContactManager") fillVariables(element);
  if (type == "RepulsiveSpringForceField") element.set("compressionOnly", "true");
  if (type == "TetrahedronFEMForceField") splitPlasticity(element);
  element.written->type = std::string(typeHere(type));
  if (type == "SubsetTopology" && element.find("centers")) tree_->retype(element, "SphereROI");
}

/// The plastic strain is a field beside the elastic one, which comes when the mesh of that is known.
void Rewriting::splitPlasticity(Element& field) {
  const bool yields = std::atof(field.text("plasticMaxThreshold").c_str()) > 0;
  const SourceLocation& where = field.written->where;
  ComponentDescription plastic{"PlasticStrainForceField", {}, where, field.written->folder};
  plastic.attributes.push_back({"name", field.name + "_plastic", where});
  for (const char* copied : {"method", "youngModulus", "poissonRatio", "plasticMaxThreshold", "plasticYieldThreshold", "plasticCreep"})
    if (const AttributeDescription* found = field.find(copied)) plastic.attributes.push_back(*found);
  for (const char* always : {"scaledByVolume", "firstForOthers", "yieldsAtStart"}) plastic.attributes.push_back({always, "true", where});
  const std::string method = field.text("method");
  if ((method == "polar" || method == "svd") && quirks_.isOn("edge-polar")) plastic.attributes.push_back({"polarOf", "edges", where});
  for (const char* moved : {"plasticMaxThreshold", "plasticYieldThreshold", "plasticCreep"}) field.remove(moved);
  if (yields) plasticity_[&field] = std::move(plastic);
}

/// A force field of hexahedra that is a mass too. SOFA couples all pairs of corners alike, with 8/27 of the cell's mass each.
void Rewriting::splitMass(Element& field) {
  const SourceLocation& where = field.written->where;
  ComponentDescription mass{"MeshMatrixMass", {}, where, field.written->folder};
  SceneTree::linkTo(field);  // has a name from now on
  const std::string density = field.find("density") ? field.text("density") : "1";
  mass.attributes.push_back({"name", field.name + "_mass", where});
  mass.attributes.push_back({"massDensity", density, where});
  mass.attributes.push_back({"computeMassOnRest", "true", where});
  if (saysYes(field.text("lumpedMass"))) mass.attributes.push_back({"lumping", "true", where});
  const bool is_exact = field.is("NonUniformHexahedralFEMForceFieldAndMass");  // as the finite element method has it
  if (is_exact || quirks_.use("pair-mass", field.path()))
    mass.attributes.push_back({"matrix", is_exact ? "consistent" : "pairs", where});
  for (const char* copied : {"topology", "rayleighMass"})
    if (const AttributeDescription* found = field.find(copied)) mass.attributes.push_back(*found);
  if (Element* mesh = meshOf(field); mesh && mesh->written->type.starts_with("SparseGrid"))
    mass.attributes.push_back({"cellFactors",
                               SceneTree::linkTo(*mesh) + (mesh->is("SparseGridMultipleTopology")
                                                               ? field.find("partFactors") ? ".partMassFactors" : ".massFactors"
                                                               : field.find("partFactors") ? ".partFactors" : ".cellFactors"),
                               where});
  if (std::atof(field.text("totalMass").c_str()) > 0) mass.attributes.push_back({"totalMass", field.text("totalMass"), where});
  if (mass.find("totalMass")) std::erase_if(mass.attributes, [](const auto& each) { return each.name == "massDensity"; });
  for (const char* moved : {"density", "lumpedMass", "rayleighMass", "massMatrices", "totalMass"}) field.remove(moved);
  field.place->added_components.push_back(std::move(mass));
}

// ---- names that a scene gives ----

/// MakeAliasComponent gives a type another name, MakeDataAliasComponent an attribute of it, for what comes after.
void Rewriting::resolveAliases() {
  std::map<std::string, std::string> types;
  std::map<std::pair<std::string, std::string>, std::string> attributes;
  const auto resolve = [&](const auto& self, NodeDescription& node) -> void {
    std::erase_if(node.components, [&](ComponentDescription& component) {
      const auto text = [&component](const char* name) {
        const AttributeDescription* found = component.find(name);
        return found ? std::string(trimmed(found->value)) : std::string();
      };
      if (component.type == "MakeAliasComponent") return types[text("alias")] = text("targetcomponent"), true;
      if (component.type == "MakeDataAliasComponent")
        return attributes[{text("componentname"), text("alias")}] = text("dataname"), true;
      if (const auto other = types.find(component.type); other != types.end()) component.type = other->second;
      for (AttributeDescription& attribute : component.attributes)
        if (const auto other = attributes.find({component.type, attribute.name}); other != attributes.end())
          attribute.name = other->second;
      return false;
    });
    for (NodeDescription& child : node.children) self(self, child);
  };
  resolve(resolve, scene_.root);
}

// ---- solvers that damp ----

/// DampVelocitySolver, which SOFA runs after the integrator of its node: v *= exp(-rate dt), and slow nodes stop, as vdamping and
/// velocityThreshold.
void Rewriting::dampVelocities() {
  tree_->forEach([this](Element& element) {
    if (!element.is("DampVelocitySolver")) return;
    Element* integrator = element.place->firstOf("integrator");
    if (!integrator) {
      element.dropped = true;
      return warn(element.written->where, element, {}, "stands beside no integrator here: it damps nothing");
    }
    const bool is_given = element.find("rate") && !element.writes("rate");
    if (is_given || !integrator->probe->data().find("velocityThreshold")) return;  // reported as what is not there
    const double rate = element.find("rate") ? std::atof(element.text("rate").c_str()) : 0.99;
    integrator->set("vdamping", printReal(rate + std::atof(integrator->text("vdamping").c_str())));
    if (std::atof(element.text("threshold").c_str()) != 0) integrator->set("velocityThreshold", element.text("threshold"));
    element.dropped = true;
    const auto line = [](const Element& each) { return std::pair(each.written->where.line, each.written->where.column); };
    if (line(element) < line(*integrator))
      warn(element.written->where, element, {}, "stands before " + integrator->path() +
           ": SOFA damps the velocities that a step starts with, and here those that it ends with");
    else
      diagnostics_.note(element.written->where, element.path(), "is vdamping of " + integrator->path() + " here");
  });
}

// ---- loops that divide a step ----

/// A loop of several steps of integration in each of the animation: the steps are those of integration.
void Rewriting::divideSteps() {
  tree_->forEach([this](Element& element) {
    if (!element.is("MultiStepAnimationLoop")) return;
    double parts = 1;
    for (const char* name : {"collisionSteps", "integrationSteps"})
      if (const std::string text = element.text(name); !text.empty()) parts *= std::max(1., std::floor(std::atof(text.c_str())));
    std::vector<AttributeDescription>& attributes = scene_.root.attributes;
    const auto dt = std::find_if(attributes.begin(), attributes.end(), [](const auto& each) { return each.name == "dt"; });
    const double step = dt == attributes.end() ? 0.01 : std::atof(dt->value.c_str());
    if (dt == attributes.end())
      attributes.push_back({"dt", printReal(step / parts), element.written->where});
    else
      dt->value = printReal(step / parts);
    element.dropped = true;
    warn(element.written->where, element, {},
         "divides each step into " + printReal(parts) + ": the scene has as many of them, of dt=\"" + printReal(step / parts) + "\"");
  });
}

// ---- mappings that pass nothing on ----

/// A VoidMapping maps nothing: its state stays where it is, and what acts there moves nothing.
void Rewriting::dropVoids() {
  static const std::set<std::string> acting = {"force field", "mass", "projective constraint", "position constraint"};
  tree_->forEach([this](Element& element) {
    if (!element.is("VoidMapping")) return;
    element.dropped = true;
    for (const auto& each : element.place->elements)
      if (acting.count(each->role())) each->dropped = true;
    diagnostics_.note(element.written->where, element.path(), "maps nothing: the nodes of " + element.place->path() + " stay");
  });
}

/// What acts on nodes that follow others is heard by nobody where the mapping passes no forces: SOFA goes no further then, and has
/// neither their force fields nor their masses. It declares mapMasses, and asks for it nowhere.
void Rewriting::dropUnheard() {
  const auto drop = [this](const auto& self, Place& place, const std::string& role, const Element& mapping) -> void {
    for (const auto& each : place.elements) {
      if (each->dropped || each->role() != role || movesElsewhere(*each)) continue;
      each->dropped = true;
      diagnostics_.note(each->written->where, each->path(), "does not count: " + mapping.path() + " passes nothing of it on");
    }
    for (const auto& child : place.children) self(self, *child, role, mapping);
  };
  tree_->forEach([&](Element& element) {
    if (element.role() != "mapping") return;
    if (saysNo(element.text("isMechanical")) || saysNo(element.text("mapForces")))
      for (const char* role : {"force field", "mass"}) drop(drop, *element.place, role, element);
    if (saysNo(element.text("mapMasses")) && hasMass(*element.place))
      warn(element.written->where, element, "mapMasses", "has no effect, as in SOFA: masses of the nodes that follow count");
    for (const char* name : {"isMechanical", "mapForces", "mapMasses", "mapConstraints"}) {
      if (!element.find(name)) continue;
      element.remove(name);
      noEffect(element.written->type + "." + name);
    }
  });
}

/// Nothing in the place or below acts on bodies: states that follow, meshes, and what only draws or makes values.
bool Rewriting::hasOnlyFollowers(const Place& place) const {
  static const std::set<std::string> followers = {"mechanical state", "topology", "topological mapping", "mapping", "mesh loader",
                                                  "selection", "engine", "mesh engine", "observer"};
  for (const auto& each : place.elements) {
    if (each->dropped || each->without_effect) continue;
    const std::string& type = each->written->type;
    if (each->probe ? !followers.count(each->role()) : !type.ends_with("Mapping") && !isEngineOfSofa(type)) return false;
  }
  return std::all_of(place.children.begin(), place.children.end(), [this](const auto& child) { return hasOnlyFollowers(*child); });
}

/// A link from elsewhere, of something with an effect, leads into the place.
bool Rewriting::isAskedFromOutside(const Place& place) const {
  const auto lies_in = [&place](const Place* where) {
    while (where && where != &place) where = where->parent;
    return where != nullptr;
  };
  bool asked = false;
  tree_->forEach([&](Element& element) {
    if (element.without_effect || lies_in(element.place)) return;
    for (const AttributeDescription& attribute : element.written->attributes)
      forLinks(attribute, [&](std::string_view word) {
        for (const bool names_data : {false, true}) {
          const LinkTarget target = tree_->follow(element, word, names_data);
          asked = asked || (target.element && lies_in(target.element->place)) || (target.place && lies_in(target.place));
        }
      });
  });
  return asked;
}

/// A mapping that is not available is missed only where something acts on the nodes that follow.
void Rewriting::dropIdleMappings() {
  tree_->forEachPlace([this](Place& place) {
    for (const auto& each : place.elements) {
      const std::string& type = each->written->type;
      const bool is_unknown = !each->dropped && !each->probe && !each->without_effect && type.ends_with("Mapping");
      if (!is_unknown || !place.parent || place.has("integrator") || !hasOnlyFollowers(place) || isAskedFromOutside(place)) continue;
      place.dropped = true;
      warn(each->written->where, *each, {},
           type + " is not available here, and nothing acts on the nodes that follow by it: the scene runs without the node " +
               place.path());
      noEffect(type + " of what nothing acts on");
      return;
    }
  });
}

// ---- several linear solvers ----

/// Of several linear solvers in a node SOFA takes the first, or the one that its integrator links. Conjugate gradients with
/// factors of the same matrix for a preconditioner give the solution of these factors.
void Rewriting::chooseSolvers() {
  tree_->forEachPlace([this](Place& place) {
    Element* integrator = place.firstOf("integrator");
    Element* chosen = place.firstOf("linear solver");
    if (!integrator || !chosen) return;
    if (const std::string link = integrator->text("linearSolver"); !link.empty())
      if (const LinkTarget target = tree_->follow(*integrator, link, false); target.element && target.element->role() == "linear solver")
        chosen = target.element;
    Element* preconditioner = chosen->is("PCGLinearSolver") ? preconditionerOf(*chosen) : nullptr;
    if (preconditioner && preconditioner->role() == "linear solver") {
      chosen->dropped = true;
      diagnostics_.note(chosen->written->where, chosen->path(),
                        "does not count: with the factors of " + preconditioner->path() + " its solution is theirs");
      if (integrator->find("linearSolver")) integrator->set("linearSolver", SceneTree::linkTo(*preconditioner));
      chosen = preconditioner, preconditioner = nullptr;
    }
    Element* factors = nullptr;  // those that the preconditioner turns
    if (preconditioner)
      for (const char* name : {"linearSolver", "solverName"})
        if (const std::string link = preconditioner->text(name); !link.empty() && !factors)
          factors = tree_->follow(*preconditioner, link, false).element;
    if (factors && preconditioner->probe->data().find("linearSolver"))
      preconditioner->set("linearSolver", SceneTree::linkTo(*factors));
    if (preconditioner && preconditioner->is("PrecomputedWarpPreconditioner") && !factors) addFactors(*preconditioner, *chosen);
    for (const auto& each : place.elements) {
      const std::string role = each->role();
      if (each->dropped || (role != "linear solver" && role != "preconditioner")) continue;
      const bool turned = role == "linear solver" && preconditioner && preconditioner->role() == "preconditioner" && !factors &&
                          preconditioner->written->type.ends_with("WarpPreconditioner") && each.get() != chosen;
      if (each.get() == chosen || each.get() == preconditioner || each.get() == factors || turned) continue;
      each->dropped = true;
      diagnostics_.note(each->written->where, each->path(), "does not count: " + chosen->path() + " solves in this node");
    }
  });
}

/// SOFA's has an inverse of its own, where here it turns the factors of a solver.
void Rewriting::addFactors(Element& preconditioner, const Element& solver) {
  for (const auto& each : preconditioner.place->elements)
    if (!each->dropped && each->role() == "linear solver" && each.get() != &solver) return;
  const SourceLocation& where = preconditioner.written->where;
  Element& factors = tree_->add(*preconditioner.place, {"SparseLDLSolver", {{"name", preconditioner.name + "_factors", where}},
                                                        where, preconditioner.written->folder});
  preconditioner.set("linearSolver", SceneTree::linkTo(factors));
}

/// By its link, or by the names that SOFA took before; null: none.
Element* Rewriting::preconditionerOf(Element& solver) {
  const std::string names = solver.text("preconditioners");
  solver.remove("preconditioners");
  const bool uses = !saysNo(solver.text("use_precond"));
  std::string link = solver.find("preconditioner") ? solver.text("preconditioner") : names;
  if (const auto blank = link.find(' '); blank != std::string::npos) link = link.substr(0, blank);
  Element* found = link.empty() || !uses ? nullptr : tree_->follow(solver, link, false).element;
  if (found && !found->dropped && found->role() == "linear solver") return found;
  if (found && !found->dropped && found->role() == "preconditioner")
    solver.set("preconditioner", SceneTree::linkTo(*found));
  else
    solver.set("preconditioner", "none"), found = nullptr;
  return found;
}

// ---- engines ----

/// An engine that is not available here is missed only where something with an effect takes what it makes.
void Rewriting::dropIdleEngines() {
  static const std::set<std::string_view> known = {"AverageCoord",      "DilateEngine",   "NormEngine",       "NormalsFromPoints",
                                                   "QuatToRigidEngine", "ROIValueMapper", "RigidToQuatEngine", "SumEngine",
                                                   "MeshSampler",       "Vertex2Frame",   "ValuesFromPositions",
                                                   "RandomPointDistributionInSurface", "MergeROIs", "SelectLabelROI",
                                                   "SelectConnectedLabelsROI", "JoinPoints", "MapIndices", "GroupFilterYoungModulus",
                                                   "MeshSplittingEngine", "ProjectiveTransformEngine", "ClusteringEngine",
                                                   "GenerateSphere", "MeshTetraStuffing", "SmoothMeshEngine"};
  const auto is_engine = [](const Element& element) {
    return !element.dropped && (!element.probe || known.count(element.written->type)) && isEngineOfSofa(element.written->type);
  };
  for (bool changed = true; changed;) {
    std::set<const Element*> asked;
    tree_->forEach([&](Element& element) {
      if (element.without_effect) return;
      for (const AttributeDescription& attribute : element.written->attributes)
        forLinks(attribute, [&](std::string_view word) {
          for (const bool names_data : {false, true})
            if (const LinkTarget target = tree_->follow(element, word, names_data); target.element && target.element != &element)
              asked.insert(target.element);
        });
    });
    changed = false;
    tree_->forEach([&](Element& element) {
      if (!is_engine(element) || asked.count(&element)) return;
      element.without_effect = element.dropped = changed = true;
      noEffect(element.written->type + ", which nothing with an effect reads");
    });
  }
}

}  // namespace stroma::sofa
