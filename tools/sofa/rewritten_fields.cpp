// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs, loads and constraints that a scene gives twice, in part or not at all: what SOFA takes of them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

std::vector<double> writtenNumbers(const std::string& text) {
  std::vector<double> numbers;
  Words words(text);
  for (std::string word(words.next()); !word.empty(); word = words.next()) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0') return {};
  }
  return numbers;
}

std::string readByStream(const std::string& text, const std::string& others) {
  std::vector<double> values = writtenNumbers(others);
  values.resize(3);
  std::istringstream numbers(text);
  for (double& value : values) {
    double number = 0;
    if (!(numbers >> std::ws) || numbers.eof()) break;
    const bool is_number = bool(numbers >> number);
    value = is_number ? number : 0;
    if (!is_number) break;
  }
  return printed(values);
}

std::string printed(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : " ") + printReal(number);
  return text;
}

/// SOFA's names of the stress that an exporter writes.
void Rewriting::meanStressFields(Element& element) {
  for (const char* name : {"cellsDataFields", "pointsDataFields"}) {
    const std::string written = element.text(name);
    if (written.find("vonMisesPer") == std::string::npos) continue;
    std::string kept;
    Words words(written);
    for (std::string word(words.next()); !word.empty(); word = words.next()) {
      if (word.ends_with("vonMisesPerElement")) word.resize(word.size() - std::string_view("PerElement").size());
      if (word.ends_with("vonMisesPerNode"))
        warn(element.find(name)->where, element, name, "has the stress of nodes, which is not there: it is left out");
      else
        kept += kept.empty() ? word : ' ' + word;
    }
    element.set(name, kept);
  }
}

/// What SOFA reads and the component here does not, as long as it can be said otherwise. Numbers that nobody gives are SOFA's,
/// without a word, as there.
void Rewriting::meanOfNames(Element& element) {
  if (element.find("numericalTolerance")) turn_tolerance_ = element.text("numericalTolerance"), element.remove("numericalTolerance");
  const bool is_sheet = isAnyOf(element.written->type,
                                {"TriangularQuadraticSpringsForceField", "TriangularBiquadraticSpringsForceField",
                                 "TriangularTensorMassForceField"});
  for (const char* name : {"stiffness", "bendingStiffness", "angularStiffness", "viscosity", "damping", "dampingCoefficient",
                           "penalty", "property", "density", "thickness"}) {
    const Data* data = element.probe ? element.probe->data().find(name) : nullptr;
    if (data && data->isPhysical() && (is_sheet || data->name() != "thickness")) setDefault(element, name, data->defaultText());
  }
  if (element.is("RestShapeSpringsForceField")) setDefault(element, "angularStiffness", "100");
  if (element.is("BeamHookeLawForceField"))
    for (const char* name : {"radius", "lengthY", "lengthZ"}) setDefault(element, name, "1");
  if (element.is("RegularGridSpringForceField") && !element.find("stiffness"))
    for (const char* name : {"linesStiffness", "quadsStiffness", "cubesStiffness"}) setDefault(element, name, "100");
  if (element.is("LinearForceField") && element.writes("force")) scaleForces(element);
  if (element.is("NodalLinearDampingForceField")) nameCoefficients(element, isOfFrames(element));
  if (element.is("NonUniformHexahedralFEMForceFieldAndMass")) meanVoxels(element);
  if (element.written->type.starts_with("SkeletalMotion")) meanSkeleton(element);
  if (element.is("SimpleTesselatedTetraTopologicalMapping"))
    for (const auto& [name, value] : {std::pair("pointBaryCoords", "0 0 0"), {"edgeBaryCoords", "0.5 0 0"}, {"splitTetrahedra", "true"}})
      element.set(name, value);
  if (element.is("SphereQuadTopology") && !element.find("radius"))
    warn(element.written->where, element, "radius", "is 0 in SOFA when not given, and the sphere a point: here it is 1");
  if (element.is("WireRestShape") && !element.find("topology"))  // it fills the container of its node
    for (const auto& other : element.place->elements)
      if (other->is("EdgeSetTopologyContainer") && !other->find("edges")) element.set("topology", SceneTree::linkTo(*other));
  if (element.is("VTKExporter")) meanStressFields(element);
  if (element.written->type.starts_with("PartialLinearMovement")) shareMovement(element);
  if (element.is("TrianglePressureForceField")) meanLayer(element);
}

/// Some spring of the field may have no length at rest.
static bool hasZeroLengths(const Element& field) {
  const bool is_whole = field.find("spring");
  const std::vector<double> numbers = writtenNumbers(field.text(is_whole ? "spring" : field.find("length") ? "length" : "lengths"));
  bool is_zero = numbers.empty();
  for (std::size_t i = is_whole ? 4 : 0; i < numbers.size(); i += is_whole ? 5 : 1) is_zero = is_zero || numbers[i] == 0;
  return is_zero;
}

/// Both ends of a field between states have a mass: without one SOFA's matrix is singular where springs do nothing.
bool Rewriting::haveMass(const Element& springs) const {
  for (const char* name : {"object1", "object2"}) {
    const std::string link = springs.text(name);
    const LinkTarget end = link.empty() ? LinkTarget{nullptr, springs.place, {}} : tree_->follow(springs, link, false);
    const Place* place = end.element ? end.element->place : end.place;
    const Element* state = place ? place->nearest("mechanical state") : nullptr;
    if (state && !state->place->has("mapping") && !hasMass(*state->place)) return false;
  }
  return true;
}

void Rewriting::meanSprings(Element& element) {
  if (!element.is("SpringForceField")) return;
  if (haveMass(element))
    setQuirk(element, "meeting-ends", "meetingEnds", "free");
  else if (hasZeroLengths(element))
    warn(element.written->where, element, {},
         "holds nodes without mass: where the ends of a spring meet SOFA's matrix is singular, and here they keep their stiffness");
  const bool has_pairs = element.find("springsIndices1") || element.find("indices1");
  if (!element.find("spring") && !has_pairs) {
    element.dropped = true;
    return warn(element.written->where, element, {}, "has no spring: it does nothing");
  }
  if (element.find("spring")) {  // with their constants
    for (const char* name : {"stiffness", "damping", "lengths", "length", "springsIndices1", "springsIndices2", "indices1", "indices2"})
      if (element.find(name)) element.remove(name), noEffect("SpringForceField." + std::string(name) + " beside spring");
    std::vector<double> springs = writtenNumbers(element.text("spring"));
    if (springs.size() % 5 == 0) return;
    warn(element.find("spring")->where, element, "spring", "has no whole spring at its end: it is left out");
    springs.resize(springs.size() / 5 * 5);
    return element.set("spring", printed(springs));
  }
  setDefault(element, "stiffness", "100"), setDefault(element, "damping", "5");
  const std::string pairs = element.text(element.find("springsIndices1") ? "springsIndices1" : "indices1");
  const std::size_t count = writtenNumbers(pairs).size();
  for (const char* name : {"stiffness", "damping", "lengths", "length"}) {
    std::vector<double> values = writtenNumbers(element.text(name));
    if (count == 0 || values.size() < 2 || values.size() == count) continue;
    warn(element.find(name)->where, element, name,
         "has " + std::to_string(values.size()) + " values for " + std::to_string(count) + " springs: SOFA goes on with the last");
    values.resize(count, values.back());
    element.set(name, printed(values));
  }
}

/// Springs of a mesh lie in one body: what SOFA's base class could link besides is that body.
void Rewriting::checkOneBody(Element& field) {
  for (const char* name : {"object1", "object2"}) {
    if (!field.find(name)) continue;
    const LinkTarget target = tree_->follow(field, field.text(name), false);
    const Element* state = target.element ? target.element : target.place ? target.place->firstOf("mechanical state") : nullptr;
    if (state && state == field.place->nearest("mechanical state")) field.remove(name);
  }
}

/// SOFA's localRange has its last node, where here it is the one after.
void Rewriting::includeLast(Element& element) {
  const std::vector<double> range = writtenNumbers(element.text("localRange"));
  if (range.size() == 2 && range[1] >= 0) element.set("localRange", printed({range[0], range[1] + 1}));
}

/// Of several of its loads the first that SOFA asks for counts.
void Rewriting::meanConstantForce(Element& load) {
  if (load.find("forces")) setDefault(load, "noneIfMismatched", "true");
  std::string counts;
  for (const char* name : {"forces", "force", "totalForce"}) {
    if (!load.find(name)) continue;
    if (!counts.empty()) {
      warn(load.find(name)->where, load, name, counts + " is given too and counts");
      load.remove(name);
    } else {
      counts = name;
    }
  }
}

/// SOFA takes the normal as it is long: depths have that factor, and forces its square.
void Rewriting::meanPlane(Element& plane) {
  const std::vector<double> normal = writtenNumbers(plane.text("normal"));
  if (!plane.writes("normal") || normal.size() != 3) return;
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (length == 0 || length == 1) return;
  const bool is_told = std::abs(length - 1) > 1e-6;  // else that of its last digits
  const auto scale = [&](const char* name, const char* value, double factor) {
    if (plane.find(name) && (!plane.writes(name) || plane.text(name).find('@') != std::string::npos)) {
      if (is_told) warn(plane.written->where, plane, name, "is no number that is written: SOFA's is " + printReal(factor) + " times it");
      return;
    }
    plane.set(name, printReal(factor * std::atof(plane.find(name) ? plane.text(name).c_str() : value)));
  };
  scale("d", "0", 1 / length), scale("stiffness", "500", length * length), scale("damping", "5", length);
  if (is_told)
    diagnostics_.note(plane.written->where, plane.path(),
                      "normal is not of unit length: SOFA multiplies depths by " + printReal(length) + " and forces by " +
                          printReal(length * length));
}

/// Whether quads may be among the faces of a load: not on a mesh of triangles alone. What a file holds is not known here.
bool Rewriting::mayLoadQuads(const Element& load) const {
  const Element* mesh = meshOf(load);
  if (!mesh || !mesh->probe || !trimmed(load.text("quadIndices")).empty()) return true;
  bool is_source = false;  // of cells that are not named
  const DataTable& table = mesh->probe->data();
  for (const AttributeDescription& attribute : mesh->written->attributes) {
    const Data* data = table.find(attribute.name);
    const bool is_given = attribute.typed || !trimmed(attribute.value).empty();
    if (is_given && data && (data == table.find("quads") || data == table.find("hexahedra"))) return true;
    is_source = is_source || isAnyOf(attribute.name, {"src", "filename", "fileTopology"});
  }
  if (isAnyOf(mesh->written->type, {"TriangleSetTopologyContainer", "TetrahedronSetTopologyContainer"})) return false;
  tree_->forEach([&](Element& element) {
    const std::string link = element.role() == "topological mapping" ? element.text("output") : "@/";
    const LinkTarget output = link.empty() ? LinkTarget{nullptr, element.place, {}} : tree_->follow(element, link, false);
    is_source = is_source || output.element == mesh || (link != "@/" && !output.element && output.place == mesh->place);
  });
  return is_source || !mesh->is("MeshTopology");
}

/// Springs of frames have forces of an energy, which SOFA's do not: their numbers differ, but for joints that are no part of a matrix.
void Rewriting::tellSpringsOfFrames(Element& element) {
  const std::string& type = element.written->type;
  if (type == "FrameSpringForceField")
    warn(element.written->where, element, {},
         "has forces of an energy here: SOFA's torques stay in fixed axes, its damping turns one of two frames on, and its matrix "
         "does not know the step");
  if (type != "JointSpringForceField") return;
  setQuirk(element, "one-sided-turns", "unbalanced", "true");
  const Element* solver = element.place->nearest("linear solver");
  if (solver && (!solver->is("CGLinearSolver") || solver->text("template").starts_with("Compressed")))
    warn(element.written->where, element, {}, "is a part of the matrix here: in SOFA it is in none that is assembled");
}

/// A box whose corners are one, as both are when they are not given, is none.
static void meanBox(Element& pressure) {
  if (pressure.writes("min") != pressure.writes("max")) pressure.set(pressure.writes("min") ? "max" : "min", "0 0 0");
  if (pressure.writes("min") && writtenNumbers(pressure.text("min")) == writtenNumbers(pressure.text("max")))
    pressure.remove("min"), pressure.remove("max");
}

/// SOFA's solvers of matrices that are not symmetric; the others of SOFA read one triangle, in an order of their own.
bool Rewriting::takesWholeTangent(const Element& solver) const {
  if (isAnyOf(solver.written->type, {"SparseLUSolver", "EigenSparseLU", "EigenSparseQR", "SVDLinearSolver"})) return true;
  return solver.is("CGLinearSolver") && quirks_.isOn("cg-threshold");
}

void Rewriting::meanLoads(Element& element) {
  const std::string& type = element.written->type;
  for (const char* name : {"activeDirections", "initialLength", "zeroLength"})
    if (element.writes(name) && element.text(name).empty()) element.remove(name);
  if (type == "RestShapeSpringsForceField" || type == "ConstantForceField") setDefault(element, "emptyMeansAll", "true");
  if (type == "RestShapeSpringsForceField") setDefault(element, "firstForOthers", "true");
  tellSpringsOfFrames(element);
  if (isAnyOf(type, {"TriangularQuadraticSpringsForceField", "LennardJonesForceField"}) || type.starts_with("Polynomial"))
    setQuirk(element, "torsion-tangent", "tangent", "rough");
  if (type == "TaitSurfacePressureForceField") setDefault(element, "maxInjectionRate", "1000");
  if (type == "ConstantForceField") meanConstantForce(element);
  if (type == "PlaneForceField") meanPlane(element);
  if (type == "ConstantForceField" && !element.find("forces") && !element.find("force") && !element.find("totalForce")) {
    element.dropped = true;
    return warn(element.written->where, element, "forces", "is not given: there is no load");
  }
  if (type == "EdgePressureForceField" && element.find("p_intensity"))
    setDefault(element, "lengths", "first"), setQuirk(element, "late-times", "late", "true");
  const bool turns = type == "OscillatingTorsionPressureForceField";
  if (turns || isAnyOf(type, {"TrianglePressureForceField", "QuadPressureForceField", "EdgePressureForceField"})) {
    if (!turns) setDefault(element, "allowEmpty", "true");
    const bool chooses = (!turns && type != "TrianglePressureForceField") || element.find("triangleList") || layers_.count(&element) ||
                         (turns && std::atof(element.text("dmin").c_str()) != std::atof(element.text("dmax").c_str()));
    element.dropped = !chooses;
    if (!chooses) return warn(element.written->where, element, "triangleList", "is not given: there is no load");
  }
  const bool is_penalty = isAnyOf(type, {"PlaneForceField", "SphereForceField", "EllipsoidForceField", "ConicalForceField"});
  if (is_penalty) includeLast(element);
  if (type == "ConicalForceField") setQuirk(element, "explicit-damping", "towardsTip", "true");
  if (is_penalty || type == "InteractionEllipsoidForceField") setDefault(element, "damping", "5");
  if (type == "RegularGridSpringForceField" && !element.find("damping"))
    for (const char* kind : {"linesDamping", "quadsDamping", "cubesDamping"}) setDefault(element, kind, "5");
  if (type == "SphereForceField") setDefault(element, "radius", "1"), setDefault(element, "center", "0 0 0");
  if (type == "SurfacePressureForceField") meanBox(element), setDefault(element, "warnOfInnerFaces", "true");
  if (type == "SurfacePressureForceField" && element.find("mainDirection"))
    warn(element.written->where, element, "mainDirection", "weighs by the normals at rest: SOFA does by those of the moment");
  if (type == "SurfacePressureForceField") {
    if (mayLoadQuads(element)) setQuirk(element, "split-quads", "quads", "halves");
    Element* integrator = element.place->nearest("integrator");
    Element* solver = integrator ? integrator->place->firstOf("linear solver") : nullptr;
    if (solver && takesWholeTangent(*solver)) setDefault(element, "tangent", "exact");
  }
  if (type == "SurfacePressureForceField" && element.find("min")) setQuirk(element, "exact-borders", "exactBorder", "true");
  if (element.text("materialName").starts_with("StVenant")) element.remove("matrixRegularization");
  if (element.text("materialName") == "BoyceAndArruda") element.set("materialName", "ArrudaBoyce");  // its name before 2023
  if (type == "TetrahedronHyperelasticityFEMForceField" || type == "StandardTetrahedralFEMForceField") meanDirections(element);
  warnOfTangents(element);
  const auto layer = layers_.find(&element);
  if (layer == layers_.end()) return;
  const SourceLocation& where = element.written->where;
  const std::string name = element.name + "_layer";
  ComponentDescription box{"BoxROI", {}, where, element.written->folder};
  for (const auto& [attribute, value] : std::vector<std::pair<std::string, std::string>>{
           {"name", name}, {"box", layer->second}, {"strict", "true"}, {"allowEmpty", "true"},
           {"exactBorder", quirks_.use("exact-borders", element.path()) ? "true" : "false"}})
    box.attributes.push_back({attribute, value, where});
  element.place->added_components.push_back(std::move(box));
  SceneTree::linkTo(element);  // nodes above it have names from now on
  element.set("triangleList", "@" + joinPath(element.place->path(), name) + ".triangleIndices");
}

/// No law of SOFA reads directions; the axes of Costa's are those of space.
void Rewriting::meanDirections(Element& field) {
  const bool is_costa = field.text("materialName") == "Costa", is_given = field.find("AnisotropyDirections");
  if (is_costa && !is_given) return field.set("AnisotropyDirections", "1 0 0  0 1 0");
  if (is_costa) return setQuirk(field, "fixed-fibres", "AnisotropyDirections", "1 0 0  0 1 0");
  if (!is_given) return;
  field.remove("AnisotropyDirections");
  noEffect("AnisotropyDirections of an isotropic law");
}

/// Without another body the points of one do not count, but that they are nodes and as many does.
void Rewriting::meanRestShape(Element& springs) {
  const Element* state = springs.place->nearest("mechanical state");
  if (state && state->text("template").starts_with("Rigid3")) setQuirk(springs, "unturned-springs", "turnTangent", "unturned");
  if (springs.find("external_rest_shape") || !springs.find("external_points")) return;
  const std::string points = springs.text("points"), others = springs.text("external_points");
  const bool is_written = points.find('@') == std::string::npos && others.find('@') == std::string::npos;
  if (is_written && !points.empty() && writtenNumbers(points).size() != writtenNumbers(others).size()) {
    springs.dropped = true;
    return warn(springs.written->where, springs, "external_points", "are not as many as points: in SOFA the springs do nothing then");
  }
  springs.set("requiredPoints", others);
  springs.remove("external_points");
}

/// What SOFA leaves to a generator of its own, and to an order of its own.
void Rewriting::warnOfChance(const Element& engine) {
  const bool is_random = engine.is("RandomPointDistributionInSurface") ||
                         (engine.is("TransformPosition") && engine.text("method") == "random");
  if (is_random) warn(engine.written->where, engine, {}, "has other random numbers than SOFA");
  if (engine.is("MeshSampler")) warn(engine.written->where, engine, {}, "begins with node 0: SOFA may choose other nodes");
  if (engine.is("GenerateSphere")) warn(engine.written->where, engine, {}, "has its nodes and cells in another order than SOFA");
  if (engine.is("MeshTetraStuffing") && saysYes(engine.text("splitTetrahedra") + engine.text("splitTetras")))
    warn(engine.written->where, engine, "splitTetrahedra", "cuts sides along other diagonals than SOFA");
}

/// How torques on frames in a body of points act on it is not known of SOFA.
void Rewriting::warnOfFrames(const Element& mapping) {
  const std::string output = mapping.text("output");
  const LinkTarget target = output.empty() ? LinkTarget{nullptr, mapping.place, {}} : tree_->follow(mapping, output, false);
  const Element* child = target.element ? target.element : target.place ? target.place->firstOf("mechanical state") : nullptr;
  if (child && child->text("template").starts_with("Rigid3"))
    warn(mapping.written->where, mapping, {},
         "its frames turn by the rotation next to the deformation, and pass torques on by its derivative: SOFA may pass other ones");
}

/// SOFA moves masses on what follows by J^T M J without the change of J along the motion. Its mappings of frames leave out how
/// the torque of a force changes as its arm turns: RigidMapping unless told otherwise, RigidRigidMapping where a matrix is
/// assembled, and others always.
void Rewriting::holdArms(Element& mapping) {
  if (mapping.is("SkinningMapping")) setDefault(mapping, "fromRest", "true");
  if (mapping.probe->data().find("convectiveInertia") && !mapping.find("convectiveInertia"))
    setQuirk(mapping, "no-centrifugal", "convectiveInertia", "false");
  const bool follows_frames = isAnyOf(mapping.written->type, {"RigidMapping", "RigidRigidMapping", "SkinningMapping", "BeamLinearMapping",
                                                              "TubularMapping", "ArticulatedSystemMapping",
                                                              "LineSetSkinningMapping", "DeformableOnRigidFrameMapping"});
  if (!follows_frames || mapping.find("geometricStiffness")) return;
  const Element* solver = mapping.place->nearest("linear solver");
  const bool is_assembled = !solver || !solver->is("CGLinearSolver") || solver->text("template").starts_with("Compressed");
  if (!mapping.is("RigidRigidMapping") || is_assembled) setQuirk(mapping, "held-arms", "geometricStiffness", "None");
}

/// In SOFA points that are listed, and rest positions with useX0, are in the axes of the frames whatever is asked.
void Rewriting::meanCarried(Element& mapping) {
  setDefault(mapping, "resizes", "true");
  setDefault(mapping, "mayMiscount", "true");
  const bool at_rest = saysYes(mapping.text("useX0"));
  const AttributeDescription* listed = mapping.find("initialPoints");
  const bool is_listed = listed && (listed->typed || !trimmed(listed->value).empty());
  const auto leave = [&](const char* attribute, const std::string& beside) {
    warn(mapping.find(attribute)->where, mapping, attribute, "has no effect beside " + beside + ", as in SOFA");
    mapping.remove(attribute);
  };
  if (is_listed && at_rest) leave("initialPoints", "useX0");
  if ((is_listed || at_rest) && saysYes(mapping.text("globalToLocalCoords")))
    leave("globalToLocalCoords", at_rest ? "useX0" : "initialPoints");
}

}  // namespace stroma::sofa
