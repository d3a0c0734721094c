// SPDX-License-Identifier: LGPL-2.1-or-later
// Parts that are one component in SOFA and another here.
// ShapeMatching is there an engine that follows a state as it moves: here what draws nodes to its goals matches the shapes itself.
// MultiAdaptiveBeamMapping fills the edges of its node there: here a topological mapping does. A TrianglePressureForceField chooses its
// triangles between two planes there: here a region does. Fields of any kind of cell are one component there: here those of edges,
// triangles and quads are another.
#include <algorithm>
#include <cstdlib>

#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

void Rewriting::matchShapes() {
  tree_->forEach([this](Element& element) {
    if (!element.is("PositionBasedDynamicsProjectiveConstraint") || element.dropped) return;
    const Element* state = element.place->nearest("mechanical state");
    for (const auto& each : element.place->elements)
      if (each->role() == "projective constraint" && !each->dropped)
        warn(element.written->where, element, {},
             "moves nodes that " + each->path() + " holds, in SOFA: here they stay where they are held");
    const LinkTarget goal = tree_->follow(element, element.text("position"), true);
    Element* shapes = goal.data == "targetPosition" ? goal.element : nullptr;
    if (!shapes || !shapes->is("ShapeMatching")) return;
    const LinkTarget source = tree_->follow(*shapes, shapes->text("position"), true);
    const LinkTarget groups = tree_->follow(*shapes, shapes->text("cluster"), true);
    const bool is_own = source.element && source.element == state && source.data == "position";
    const bool is_fixed = shapes->find("fixedPosition") || shapes->find("fixedPosition0") || shapes->find("fixedweight");
    if (!is_own || !groups.element || is_fixed)
      return diagnostics_.error(shapes->written->where, shapes->path(),
                                "ShapeMatching of other positions than those of the state that is drawn, or with fixed points, is not "
                                "available here",
                                "position=\"@" + (state ? state->name : "state") + ".position\" and cluster=\"@engine.cluster\"");
    element.remove("position");
    element.set("cluster", SceneTree::linkTo(*groups.element) + "." + groups.data);
    for (const char* name : {"iterations", "affineRatio"})
      if (shapes->find(name)) element.set(name, shapes->text(name));
    shapes->dropped = shapes->without_effect = true;
    diagnostics_.note(shapes->written->where, shapes->path(), "is a part of " + element.path() + " here");
  });
}

/// The kind of cells that a field names: by its template, or by SOFA's newer attributes of the two parts of one.
void Rewriting::meanThinCells(Element& field) {
  if (!isAnyOf(field.written->type, {"CorotationalFEMForceField", "LinearSmallStrainFEMForceField"})) return;
  std::string word = field.text("template");
  if (const std::string kind = field.text("elementType"); !kind.empty() && word.find(',') == std::string::npos)
    word = (field.find("dofType") ? field.text("dofType") : word.empty() ? "Vec3" : word) + "," + kind;
  for (const char* name : {"elementType", "dofType"}) field.remove(name);
  if (word.empty()) return;
  field.set("template", word);
  const bool turns = field.written->type == "CorotationalFEMForceField";
  for (const auto& [kind, cells] : {std::pair("Edge", "edges"), {"Triangle", "triangles"}, {"Quad", "quads"}}) {
    if (!word.ends_with(std::string(",") + kind)) continue;
    const bool is_frame = turns && cells == std::string_view("triangles") && word.starts_with("Vec3");
    const std::string way = !turns ? "identity" : field.find("rotationMethod") ? field.text("rotationMethod") : is_frame ? "triangle" : "";
    if (way == "polar")
      warn(field.find("rotationMethod")->where, field, "rotationMethod",
           "has no defined factor of a flat cell in SOFA: here it is stable_polar");
    tree_->retype(field, "ThinCellsFEMForceField");
    for (const char* name : {"template", "rotationMethod", "method"}) field.remove(name);
    field.set("cells", cells);
    field.set("rotation", way == "identity" ? "none" : way == "triangle" ? "frame" : "nodes");
    if (word.starts_with("Vec2")) field.set("planeStress", "true");
    setDefault(field, "firstForOthers", "true"), setDefault(field, "thickness", "1");
    return;
  }
}

void Rewriting::makeChains() {
  tree_->forEach([this](Element& element) { meanThinCells(element); });
  std::vector<std::pair<Element*, Element*>> chains;
  tree_->forEach([&](Element& element) {
    if (!element.is("MultiAdaptiveBeamMapping")) return;
    for (const auto& other : element.place->elements)
      if (other->is("EdgeSetTopologyContainer")) {
        chains.emplace_back(&element, other.get());
        break;
      }
  });
  for (const auto& [mapping, container] : chains) {
    for (const char* name : {"position", "points", "edges", "src", "nbPoints"}) container->remove(name);  // cleared there
    const SourceLocation& where = mapping->written->where;
    ComponentDescription edges{"MultiAdaptiveBeamTopologicalMapping", {}, where, mapping->written->folder};
    for (const char* name : {"ircontroller", "controller"})
      if (mapping->find(name)) edges.attributes.push_back({"ircontroller", mapping->text(name), where});
    edges.attributes.push_back({"output", SceneTree::linkTo(*container), where});
    tree_->add(*mapping->place, std::move(edges));
  }
}

/// Of pressure and cauchyStress one counts in SOFA, which gives a stress no stiffness.
void Rewriting::meanStress(Element& load) {
  const bool is_stress = saysNo(load.text("useConstantForce"));
  const char* unread = is_stress ? "pressure" : "cauchyStress";
  if (const AttributeDescription* given = load.find(unread)) {
    warn(given->where, load, unread, is_stress ? "does not count without useConstantForce: cauchyStress acts"
                                               : "does not count with useConstantForce: pressure acts");
    load.remove(unread);
  }
  if (!is_stress) return;
  load.dropped = trimmed(load.text("cauchyStress")).empty();
  if (load.dropped) return warn(load.written->where, load, {}, "has no cauchyStress, which is zero in SOFA then: it does nothing");
  setQuirk(load, "torsion-tangent", "useTangentStiffness", "false");
}

/// Triangles between two planes; the planes choose where dmin and dmax differ.
void Rewriting::meanLayer(Element& load) {
  meanStress(load);
  if (load.find("normal") && !load.find("dmin") && !load.find("dmax"))
    load.remove("normal"), noEffect("TrianglePressureForceField.normal without dmin and dmax");
  if (!load.writes("normal") || !load.writes("dmin") || !load.writes("dmax")) return;
  const std::vector<double> normal = writtenNumbers(load.text("normal"));
  const auto given = [](double n) { return n != 0; };
  if (normal.size() != 3 || std::count_if(normal.begin(), normal.end(), given) != 1) return;
  const auto axis = std::size_t(std::find_if(normal.begin(), normal.end(), given) - normal.begin());
  double low = std::atof(load.text("dmin").c_str()) / normal[axis], high = std::atof(load.text("dmax").c_str()) / normal[axis];
  if (low > high) std::swap(low, high);
  constexpr double far = 1e30;
  std::vector<double> box(6, -far);
  std::fill(box.begin() + 3, box.end(), far);
  box[axis] = low, box[3 + axis] = high;
  if (!load.find("triangleList")) layers_[&load] = printed(box);
  for (const char* name : {"normal", "dmin", "dmax"}) load.remove(name);
}

/// Processes 1 and 2 of SOFA add up small turns about axes of the parent or of the child, and 0 turns by the whole angle.
void Rewriting::meanJoint(Element& joint) {
  const std::string process = joint.text("articulationProcess");
  if (process != "1" && process != "2") return;
  warn(joint.written->where, joint, "articulationProcess",
       "adds up the turns of all steps in SOFA: here the child turns by the whole angle, which is the same while the axis keeps its "
       "direction");
  joint.remove("articulationProcess");
}

/// A region takes the nodes of the state beside it, else of a loader beside it, else of a state above. Meshes do not count.
void Rewriting::findNodesOfRegions() {
  tree_->forEach([this](Element& region) {
    const bool takes_nodes = region.role() == "selection" && region.probe->data().find("allowEmpty");
    if (!takes_nodes || region.find("position") || region.find("rest_position")) return;
    const Place& here = *region.place;
    if (here.has("mechanical state")) return;
    Element* loader = here.firstOf("mesh loader");
    if (loader && !here.has("topology")) region.set("position", SceneTree::linkTo(*loader) + ".position");
    if (!loader && !here.nearest("mechanical state")) blind_.insert(&region);
  });
}

/// Some regions begin with node 0 selected, and keep it where they find no nodes.
void Rewriting::emptyRegion(Element& region) {
  const bool keeps_first = isAnyOf(region.type_abroad, {"BoxROI", "SphereROI", "MeshROI"});
  const std::string link = SceneTree::linkTo(region);
  bool is_asked = false;
  if (keeps_first)
    tree_->forEach([&](Element& element) {
      for (AttributeDescription& attribute : element.written->attributes)
        if (isAnyOf(attribute.value, {link + ".indices", link + ".pointIndices"})) attribute.value = "0", is_asked = true;
    });
  region.set("position", "");
  warn(region.written->where, region, {},
       is_asked ? "finds no state or loader to take nodes of: its indices are node 0, as in SOFA"
                : "finds no state or loader to take nodes of: it selects nothing, as in SOFA",
       "position=\"@state.rest_position\"");
}

/// SOFA finds the cell of a point off a mesh by its centre, and that of a point in a grid where the grid is. A state that scales, turns and
/// translates its nodes takes the origin of a RegularGridTopology with it, and neither its axes nor its spacing; a SparseGridTopology
/// stays, and so do grids whose state has positions of its own.
void Rewriting::meanEmbedding(Element& mapping) {
  setQuirk(mapping, "centre-cells", "foundBy", "centres");
  const Place* parent = mapping.place->parent;
  const Element* state = parent ? parent->nearest("mechanical state") : nullptr;
  const Element* grid = state ? state->place->firstOf("topology") : nullptr;
  if (!grid || !isAnyOf(grid->written->type, {"RegularGridTopology", "SparseGridTopology"})) return;
  const auto gives = [state](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [state](const char* name) { return state->find(name) != nullptr; });
  };
  const bool has_places = gives({"position", "rest_position", "src", "filename"});
  const bool moves = gives({"scale", "scale3d", "rotation", "translation", "rotation2", "translation2", "sx", "sy", "sz", "rx", "ry", "rz",
                            "dx", "dy", "dz", "rx2", "ry2", "rz2", "dx2", "dy2", "dz2"});
  if (!has_places && !moves) return;
  const bool stays = has_places || grid->is("SparseGridTopology");
  setQuirk(mapping, "centre-cells", "cellsOf", stays ? "grid" : "moved_grid");
}

}  // namespace stroma::sofa
