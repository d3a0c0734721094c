// SPDX-License-Identifier: LGPL-2.1-or-later
// What a component means in SOFA, written as attributes of the one here. Each that stands for a quirk asks for its flag.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

Vec3 numbersOf(const std::string& text, const Vec3& otherwise) {
  Vec3 value = otherwise;
  if (Data("value", &value).parse(text, DataOrigin::written)) return otherwise;
  return value;
}

std::string print(const Vec3& v) { return printReal(v[0]) + " " + printReal(v[1]) + " " + printReal(v[2]); }

}  // namespace

void Rewriting::applyMeaning(Element& element) {
  if (!element.probe || element.without_effect || actsOnNothing(element)) return;
  const std::string role = element.role();
  if (role == "linear solver" || role == "integrator" || role == "Newton solver") meanSolver(element);
  if (role == "selection") meanSelection(element);
  if (role == "force field") meanField(element);
  if (element.is("SphereForceField") && std::atof(element.text("stiffness").c_str()) < 0)
    warn(element.find("stiffness")->where, element, "stiffness",
         "is below 0: SOFA's sphere then draws nodes inside to its centre, and here it keeps nodes inside");
  if (role == "mass") meanMass(element);
  if (element.is("AdaptiveBeamForceFieldAndMass")) setQuirk(element, "fixed-inertia", "turningForces", "false");
  if (role == "constraint correction") meanCorrection(element);
  if (role == "topology") meanMesh(element);
  if (role == "mechanical state") meanState(element);
  if (role == "projective constraint") meanConstraint(element);
  if (role == "Lagrangian constraint") meanForceOfConstraint(element);
  if (element.is("BilateralLagrangianConstraint") && saysYes(element.text("keepOrientationDifference")))
    setDefault(element, "keepCentreDifference", "true");
  if (element.is("FixedLagrangianConstraint")) setDefault(element, "atRest", "true");
  if (element.is("StopperLagrangianConstraint")) setDefault(element, "startsInside", "true");
  if (element.is("ArticulationCenter")) meanJoint(element);
  meanTimes(element);
  if (isActuator(element)) meanActuator(element);
  // rest positions stay as they are written: in the axes of the frames
  if (isAnyOf(element.written->type, {"RigidMapping", "DeformableOnRigidFrameMapping"}))
    setDefault(element, "applyRestPosition", "false");
  if (element.role() == "mapping") holdArms(element);
  if (isAnyOf(element.written->type, {"RigidMapping", "RigidRigidMapping"})) meanCarried(element);
  if (isAnyOf(element.written->type, {"IdentityMapping", "SubsetMapping"})) setDefault(element, "resizes", "true");
  if (element.is("BarycentricMapping")) warnOfFrames(element), meanEmbedding(element);
  if (element.is("CollisionResponse")) takeFriction(element);
  if (role == "engine" || role == "mesh engine") warnOfChance(element);
  if (element.is("ValuesFromPositions")) setDefault(element, "extent", "x");
  if (element.is("SSORPreconditioner") && !element.text("template").ends_with("Mat3x3")) setDefault(element, "scalar", "true");
  if (element.is("IndexValueMapper")) setDefault(element, "value", "0");
  if (element.is("ValuesFromPositions") && writtenNumbers(element.text("inputValues")).size() != 1)
    warn(element.written->where, element, "direction", "runs from the least x to the largest, whichever way it points, as in SOFA");
  for (const char* name : {"first", "last"})  // -1: not given
    if (element.is("SubsetMapping") && element.text(name).starts_with("-")) element.remove(name);
  if (role == "mesh loader") setDefault(element, "pointsOnly", "true");
  if (role == "mesh loader" && element.writes("scale") && element.writes("scale3d")) {  // both count
    const Vec3 scale = std::atof(element.text("scale").c_str()) * numbersOf(element.text("scale3d"), Vec3::Ones());
    element.set("scale3d", print(scale)), element.remove("scale");
  }
}

void Rewriting::setQuirk(Element& element, std::string_view quirk, const std::string& attribute,
                         const std::string& value) {
  if (!element.probe->data().find(attribute))
    return warn(element.written->where, element, {}, "has not SOFA's way '" + std::string(quirk) + "': the result differs");
  const bool is_ours = element.name.starts_with("held_by_the_scene_");  // which no scene wrote
  if (is_ours ? quirks_.isOn(quirk) : quirks_.use(quirk, element.path())) element.set(attribute, value);
}

/// Ten numbers a plane, three corners and a depth: in SOFA the second corner is that between the others, here the first is.
static std::string cornersInOrder(const std::string& planes) {
  std::vector<std::string> numbers;
  Words words(planes);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) numbers.emplace_back(word);
  for (std::size_t i = 0; i + 10 <= numbers.size(); i += 10)
    std::swap_ranges(numbers.begin() + long(i), numbers.begin() + long(i) + 3, numbers.begin() + long(i) + 3);
  return fmt::format("{}", fmt::join(numbers, " "));
}

void Rewriting::meanSelection(Element& element) {
  const Place& here = *element.place;  // without a state or a loader there SOFA asks the state above, whatever mesh is there
  const bool is_told = element.find("position") || element.find("rest_position") || !element.probe->data().find("position");
  Element* above = is_told || here.firstOf("mechanical state") || here.firstOf("mesh loader") ? nullptr : here.nearest("mechanical state");
  if (above && here.firstOf("topology")) element.set("position", SceneTree::linkTo(*above) + ".rest_position");
  setDefault(element, "allowEmpty", "true");
  if (blind_.count(&element)) emptyRegion(element);
  if (element.probe->data().find("exactBorder")) setQuirk(element, "exact-borders", "exactBorder", "true");
  if (element.is("PlaneROI") && element.find("plane") && !element.text("plane").starts_with("@"))
    element.set("plane", cornersInOrder(element.text("plane")));
  if (element.is("BoxROI") && !element.find("box") && !element.find("orientedBox")) {
    warn(element.written->where, element, "box", "is not given: SOFA takes the unit cube");
    element.set("box", "0 0 0 1 1 1");
  }
}

void Rewriting::meanMembrane(Element& element) {
  const std::string &type = element.written->type, method = element.text("method");
  const bool membrane = isAnyOf(type, {"TriangularFEMForceField", "TriangleFEMForceField", "TriangularAnisotropicFEMForceField"});
  if (membrane && method != "small") setQuirk(element, "membrane-shape", "strain", "current");
  if (type == "TriangularAnisotropicFEMForceField" && method == "small")
    warn(element.written->where, element, "method",
         "of SOFA takes fibres in the axes of each first edge and strains in x and y: here both are in the same axes");
  if (type == "QuadBendingFEMForceField")
    for (const auto& [attribute, word] : {std::pair("strain", "current"), std::pair("axes", "world")})
      setQuirk(element, "membrane-shape", attribute, word);
  if (membrane || type == "TriangularFEMForceFieldOptim" || type == "QuadBendingFEMForceField") setDefault(element, "thickness", "1");
}

void Rewriting::meanPrisms(Element& element) {
  if (!isAnyOf(element.written->type, {"LinearSmallStrainFEMForceField", "CorotationalFEMForceField"})) return;
  const std::string kind = element.text("template");
  const bool is_prism = kind.ends_with("Prism"), turns = element.written->type == "CorotationalFEMForceField";
  if (turns && (is_prism || kind.ends_with("Pyramid"))) setDefault(element, "rotationMethod", "stable_polar");
  const bool by_gradients = turns && element.text("rotationMethod") != "identity" && !quirks_.isOn("edge-polar");
  if (is_prism && !by_gradients) setQuirk(element, "prism-points", "reducedIntegration", "true");
}

/// Fields whose volume change can be a mean, which SOFA does not have.
static bool mayTakeMeans(const std::string& type) {
  return isAnyOf(type, {"TetrahedronFEMForceField", "TetrahedralCorotationalFEMForceField", "HexahedronFEMForceField",
                        "CorotationalFEMForceField", "FastTetrahedralCorotationalForceField", "LinearSmallStrainFEMForceField",
                        "HyperelasticityFEMForceField"});
}

/// Of several materials of a node SOFA takes the first.
static void takeMaterial(Element& field) {
  if (!trimmed(field.text("material")).empty()) return;
  if (Element* material = field.place->nearest("hyperelastic material")) field.set("material", SceneTree::linkTo(*material));
}

/// Constants over lengths, which in a grid are its own; lines are the edges that a mesh lists.
void Rewriting::meanSpringsOfMesh(Element& springs) {
  setQuirk(springs, "spring-length", "perLength", "true"), setDefault(springs, "allowEmpty", "true");
  if (springs.is("RegularGridSpringForceField")) return setQuirk(springs, "spring-length", "gridLengths", "true");
  if (springs.find("localRange")) setDefault(springs, "rangeByEnds", "true");
  const Element* mesh = meshOf(springs);
  if (mesh && (mesh->writes("edges") || mesh->writes("lines"))) setDefault(springs, "listedLines", "true");
  const auto& written = springs.written->attributes;
  springs.dropped = std::none_of(written.begin(), written.end(), [](const AttributeDescription& each) {
    return each.name.ends_with("tiffness") || each.name.ends_with("amping");
  });
  if (springs.dropped) warn(springs.written->where, springs, {}, "has no stiffness: it does nothing");
}

void Rewriting::meanField(Element& element) {
  const std::string& type = element.written->type;
  meanSprings(element), meanLoads(element), meanPrisms(element);
  if (element.dropped) return;
  const bool corotational = isAnyOf(type, {"TetrahedronFEMForceField", "TetrahedralCorotationalFEMForceField"});
  if (mayTakeMeans(type) && quirks_.use("local-dilatation", element.path())) setDefault(element, "dilatation", "local");
  const std::string method = element.text("method");
  for (const char* name : {"youngModulus", "poissonRatio"})
    if (element.text(name).find_first_of("@ \t\n") != std::string::npos) setDefault(element, "firstForOthers", "true");
  const bool is_box = isAnyOf(type, {"HexahedronFEMForceField", "NonUniformHexahedronFEMForceField",
                                    "HexahedronCompositeFEMForceField"}) && method == "polar";
  const bool of_edges = is_box || (corotational && isAnyOf(method, {"polar", "svd"})) || method == "polar2";
  const bool of_nodes = type == "CorotationalFEMForceField" && isAnyOf(element.text("rotationMethod"), {"polar", "stable_polar"});
  if (of_edges && saysYes(element.text("updateStiffnessMatrix")))
    warn(element.written->where, element, "updateStiffnessMatrix", "takes polar factors of deformation gradients here, and SOFA of edges");
  else if (of_edges || of_nodes)
    setQuirk(element, "edge-polar", "polarOf", of_nodes ? "nodes" : "edges");
  if (type == "TetrahedronFEMForceField") cutHexahedra(element);
  if (type == "HyperelasticityFEMForceField") takeMaterial(element);
  if (const auto plastic = plasticity_.find(&element); plastic != plasticity_.end()) {
    if (const AttributeDescription* mesh = element.find("topology")) plastic->second.attributes.push_back(*mesh);
    element.place->added_components.push_back(plastic->second);
  }
  if (type == "HexahedronFEMForceField")
    if (Element* mesh = meshOf(element); mesh && mesh->written->type.starts_with("SparseGrid"))
      setDefault(element, "localStiffnessFactor", SceneTree::linkTo(*mesh) + ".cellFactors");
  if (isAnyOf(type, {"TriangularBendingSprings", "QuadBendingSprings"})) setDefault(element, "allowEmpty", "true");
  if (isAnyOf(type, {"MeshSpringForceField", "RegularGridSpringForceField"})) meanSpringsOfMesh(element);
  // without another body they count in the same rest shape
  if (type == "RestShapeSpringsForceField") meanRestShape(element);
  if (type == "SurfacePressureForceField") meanPulse(element);
  if (element.dropped) return;
  if (element.probe->data().find("explicitDamping") && !element.find("explicitDamping") &&
      quirks_.use("explicit-damping", element.path()))
    element.set("explicitDamping", "true");
  if (type == "FastTriangularBendingSprings") {
    setQuirk(element, "edge-bending", "method", "springs");
    setDefault(element, "bendingStiffness", "1"), setDefault(element, "minDistValidity", "1e-06");
  }
  if (type == "TetrahedronDiffusionFEMForceField") setDefault(element, "constantDiffusionCoefficient", "1");
  if (type == "BeamFEMForceField") setQuirk(element, "first-end-beams", "axes", "firstEnd"), setDefault(element, "poissonRatio", "0.49");
  if (isAnyOf(type, {"AngularSpringForceField", "GearSpringForceField"})) setQuirk(element, "one-sided-turns", "oneSided", "true");
  if (isAnyOf(type, {"EllipsoidForceField", "InteractionEllipsoidForceField"})) {
    setQuirk(element, "ellipsoid-ratio", "depth", "ratio");
    if (element.is("InteractionEllipsoidForceField")) setQuirk(element, "ellipsoid-ratio", "onCentre", "true");
  }
  const bool is_pair = element.find("object1") || element.find("object2");
  if (is_pair && !element.place->nearest("integrator")) setQuirk(element, "isolated-springs", "explicitForce", "true");
  if (type == "DiagonalVelocityDampingForceField") setDefault(element, "lastForOthers", "true");
  if (type == "TorsionForceField") setQuirk(element, "torsion-tangent", "tangent", "transverse");
  meanMembrane(element);
}

/// The mesh that SOFA gives to a component: the one that it links, the last of its node, else the nearest above.
Element* Rewriting::meshOf(const Element& element) const {
  if (const std::string link = element.text("topology"); !link.empty())
    return tree_->follow(element, link, false).element;
  Element* mesh = nullptr;
  for (const auto& each : element.place->elements)
    if (!each->dropped && each->role() == "topology") mesh = each.get();
  return mesh || !element.place->parent ? mesh : element.place->parent->nearest("topology");
}

/// On a grid, which has no tetrahedra, SOFA's force field cuts each cell into six, mirrored from cell to cell. (On other meshes
/// of hexahedra it mirrors as if they were two cells wide, and the tetrahedra do not fit: the field then says what it needs.)
void Rewriting::cutHexahedra(Element& field) {
  Element* mesh = meshOf(field);
  if (!mesh || !isAnyOf(mesh->written->type, {"RegularGridTopology", "CylinderGridTopology", "SphereGridTopology"})) return;
  const auto component = [&field](std::string type, std::vector<std::pair<std::string, std::string>> attributes) {
    ComponentDescription made{std::move(type), {}, field.written->where, field.written->folder};
    for (auto& [name, value] : attributes) made.attributes.push_back({name, value, field.written->where});
    return made;
  };
  NodeDescription cells;
  cells.where = field.written->where;
  cells.folder = field.written->folder;
  const std::string name = field.name + "_cells", input = SceneTree::linkTo(*mesh);
  cells.attributes.push_back({"name", name, cells.where});
  cells.components.push_back(component("TetrahedronSetTopologyContainer", {{"name", "tetrahedra"}}));
  cells.components.push_back(component("Hexa2TetraTopologicalMapping", {{"name", "cut"},
                                                                        {"input", input},
                                                                        {"output", "@tetrahedra"},
                                                                        {"cutting", "mirrored"}}));
  field.place->added_children.push_back(std::move(cells));
  SceneTree::linkTo(field);  // nodes above it have names from now on
  field.set("topology", "@" + joinPath(field.place->path(), name) + "/tetrahedra");
}

void Rewriting::meanMesh(Element& element) {
  const std::string& type = element.written->type;
  setDefault(element, "allowEmpty", "true");
  if (element.find("src")) leaveOtherCells(element);
  takeNodesOfNeighbour(element);
  if (isAnyOf(type, {"RegularGridTopology", "CylinderGridTopology", "SphereGridTopology"})) completeGrid(element);
  if (type != "RegularGridTopology") return;
  setDefault(element, "allowMirrored", "true");
  const std::array<std::array<const char*, 2>, 3> names = {{{"xmin", "xmax"}, {"ymin", "ymax"}, {"zmin", "zmax"}}};
  Vec3 low = numbersOf(element.text("min"), Vec3::Zero()), high = numbersOf(element.text("max"), Vec3::Ones());
  bool given = element.find("min") || element.find("max");
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t end = 0; end < 2; ++end)
      if (const std::string text = element.text(names[std::size_t(axis)][end]); !text.empty()) {
        (end == 0 ? low : high)[axis] = float(numbersOf(text + " 0 0", Vec3::Zero())[0]);
        given = true;
      }
  if (!given) return;
  const bool moves = element.find("p0") && quirks_.use("grid-origin", element.path());
  if (moves) {
    const Vec3 origin = numbersOf(element.text("p0"), low), box = high - low;
    low = origin, high = origin + box;
  }
  element.remove("p0");
  // one layer of nodes lies in the middle of x and y
  const Vec3 count = element.find("n") ? numbersOf(element.text("n"), Vec3(2, 2, 2)) : Vec3(2, 2, 2);
  const char* counts[3] = {"nx", "ny", "nz"};
  int ones = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string text = element.text(counts[axis]);
    const double n = text.empty() ? count[axis] : numbersOf(text + " 0 0", Vec3(2, 2, 2))[0];
    if (n != 1) continue;
    ++ones;
    if (axis < 2 && !moves) low[axis] = (low[axis] + high[axis]) / 2;
    high[axis] = low[axis];
  }
  for (const auto& axis : names)
    for (const char* name : axis) element.remove(name);
  if (ones == 3) {  // a point
    std::erase_if(element.written->attributes, [](const AttributeDescription& attribute) { return attribute.name != "name"; });
    tree_->retype(element, "PointSetTopologyContainer");
    return element.set("position", print(low));
  }
  element.set("min", print(low));
  element.set("max", print(high));
}

/// Whether a mesh brings its nodes along.
bool Rewriting::hasOwnNodes(const Element& mesh) const {
  if (mesh.written->type.ends_with("GridTopology") || mesh.is("CubeTopology")) return true;
  for (const char* name : {"position", "points", "src", "filename", "fileTopology"})
    if (mesh.find(name)) return true;
  bool is_filled = false;
  tree_->forEach([&](Element& element) {
    if (element.role() != "topological mapping") return;
    const std::string output = element.text("output");
    const LinkTarget target = output.empty() ? LinkTarget{nullptr, element.place, {}} : tree_->follow(element, output, false);
    is_filled = is_filled || target.element == &mesh || (!target.element && target.place == mesh.place);
  });
  return is_filled;
}

/// A container of SOFA takes from its `src` the cells that it has a list for.
void Rewriting::leaveOtherCells(Element& container) {
  static const std::vector<std::pair<std::string_view, std::vector<const char*>>> others = {
      {"PointSetTopologyContainer", {"edges", "triangles", "quads", "tetrahedra", "hexahedra"}},
      {"EdgeSetTopologyContainer", {"triangles", "quads", "tetrahedra", "hexahedra"}},
      {"TriangleSetTopologyContainer", {"quads", "tetrahedra", "hexahedra"}},
      {"QuadSetTopologyContainer", {"triangles", "tetrahedra", "hexahedra"}},
      {"TetrahedronSetTopologyContainer", {"quads", "hexahedra"}},
      {"HexahedronSetTopologyContainer", {"triangles", "tetrahedra"}}};
  for (const auto& [type, names] : others)
    if (container.is(type))
      for (const char* name : names) setDefault(container, name, "");
}

/// SOFA's grids list quads, triangles of the quads, and the edges of these. Those of a solid are made where somebody asks for them.
void Rewriting::completeGrid(Element& grid) {
  const bool all_three = grid.find("nx") && grid.find("ny") && grid.find("nz");
  if (grid.find("n") && all_three) grid.remove("n");  // nx, ny and nz together win, and one of them alone does not count
  if (grid.find("n") && !all_three)
    for (const char* name : {"nx", "ny", "nz"}) grid.remove(name);
  bool asked = false;
  tree_->forEach([&](Element& element) {
    const std::string& type = element.written->type;
    asked = asked || isAnyOf(type, {"MeshSpringForceField", "VectorSpringForceField", "SurfacePressureForceField",
                                    "TrianglePressureForceField",
                                    "QuadPressureForceField", "EdgePressureForceField", "LineCollisionModel", "DistanceMapping",
                                    "SquareDistanceMapping", "AreaMapping"});
    for (const AttributeDescription& attribute : element.written->attributes)
      for (const char* list : {".edges", ".lines", ".quads", ".triangles"})
        asked = asked || trimmed(attribute.value) == "@" + grid.path() + list;
  });
  const Vec3 count = grid.find("n") ? numbersOf(grid.text("n"), Vec3(2, 2, 2)) : Vec3(2, 2, 2);
  bool flat = (count.array() == 1).any();
  for (const char* name : {"nx", "ny", "nz"}) flat = flat || grid.text(name) == "1";
  if (flat || asked) setDefault(grid, "computeTriangleList", "true");
  if (!asked) return;
  setDefault(grid, "computeQuadList", "true");
  setDefault(grid, "computeEdgeList", "true");
}

/// xmin, ymin, ... as min and max.
void Rewriting::joinCorners(Element& element) {
  const char* names[2][3] = {{"xmin", "ymin", "zmin"}, {"xmax", "ymax", "zmax"}};
  const char* joined[2] = {"min", "max"};
  for (std::size_t end = 0; end < 2; ++end) {
    Vec3 corner = numbersOf(element.text(joined[end]), Vec3::Zero());
    bool given = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const std::string text = element.text(names[end][axis]); !text.empty()) {
        corner[Index(axis)] = float(numbersOf(text + " 0 0", Vec3::Zero())[0]);
        element.remove(names[end][axis]);
        given = true;
      }
    if (given) element.set(joined[end], print(corner));
  }
}

/// Every topology of SOFA reads files; here loaders do.
void Rewriting::readMeshFiles(Element& element) {
  if (element.is("SparseGridMultipleTopology")) return readSurfaces(element);
  const std::string& type = element.written->type;
  for (const char* file : {"filename", "fileTopology"})
    if (element.probe && element.find(file) &&
        (type == "MeshTopology" || type.starts_with("SparseGrid") || type.ends_with("TopologyContainer")))
      readMeshFile(element, file);
}

void Rewriting::readMeshFile(Element& element, const std::string& attribute) {
  const std::string file = element.text(attribute);
  if (file.empty() || file.starts_with("@")) return;
  if (const std::string_view type = loaderOf(file); !type.empty()) {
    const std::string name = element.name + "_file";
    ComponentDescription loader{std::string(type), {}, element.written->where, element.written->folder};
    loader.attributes.push_back({"name", name, element.find(attribute)->where});
    loader.attributes.push_back({"filename", file, element.find(attribute)->where});
    element.place->added_components.push_back(std::move(loader));
    SceneTree::linkTo(element);
    element.remove(attribute);
    element.set("src", "@" + joinPath(element.place->path(), name));
    return;
  }
  diagnostics_.error(element.find(attribute)->where, element.path() + "." + attribute,
                     "there is no loader for " + inQuotes(file), "a file of Gmsh, OBJ, STL, OFF, VTK, GID, .xs3 or .trian");
}

}  // namespace stroma::sofa
