// SPDX-License-Identifier: LGPL-2.1-or-later
// Links as SOFA follows them, written as absolute ones.
#include <algorithm>
#include <cctype>
#include <set>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

constexpr const char* nowhere = "leads nowhere";

/// Volume cells that SOFA's grid has a list for and the one here has not, such as tetrahedra: that list is empty there. (SOFA fills
/// the lists of edges and faces, and those of a file, with what there is.)
bool isEmptyList(const LinkTarget& target) {
  if (!target.element || !target.element->probe) return false;
  const std::string& type = target.element->written->type;
  const bool is_grid = type.ends_with("GridTopology") || isAnyOf(type, {"CubeTopology", "SphereQuadTopology"});
  return is_grid && !target.element->probe->data().find(target.data) &&
         isAnyOf(target.data, {"tetrahedra", "tetras", "hexahedra", "hexas", "prisms", "pentahedra", "pentas", "pyramids"});
}

/// Scenes ask loaders for velocities, which no file of a mesh has.
bool isVelocityOfFile(const LinkTarget& target) {
  return target.element && target.element->probe && target.data == "velocity" && target.element->role() == "mesh loader" &&
         !target.element->probe->data().find(target.data);
}

}  // namespace

void Rewriting::rewriteLinks(Element& element) {
  std::vector<std::string> broken;
  for (AttributeDescription& attribute : element.written->attributes)
    if (trimmed(attribute.value).starts_with("@")) rewriteLink(element, attribute, broken);
  for (const std::string& name : broken) element.remove(name);
}

void Rewriting::rewriteLink(Element& element, AttributeDescription& attribute, std::vector<std::string>& broken) {
  if (!element.probe || element.without_effect || hasNoEffect(element.written->type, attribute.name)) return;
  const std::string text(trimmed(attribute.value));
  const auto tell = [&](const std::string& link, const std::string& message) {
    warn(attribute.where, element, attribute.name,
         "the link " + inQuotes(link) + " " + message + ": SOFA runs without it, and so does this scene",
         message == nowhere ? tree_->nearestLink(element, link) : "");
  };
  const auto breaks = [&](const std::string& message) {
    tell(text, message);
    broken.push_back(attribute.name);
  };
  if (attribute.name == "src") {
    const LinkTarget target = tree_->follow(element, text, false);
    if (!target.element || target.element->dropped) return breaks(nowhere);
    if (target.element->probe) attribute.value = SceneTree::linkTo(*target.element);
    return;
  }
  const Data* data = element.probe->data().find(attribute.name);
  if (!data) return;
  const bool many = text.find('@', 1) != std::string::npos;
  std::string value;
  if (data->link() && (!many || !data->link()->takesMany())) {
    value = componentLink(element, *data, text);
  } else if (data->link()) {
    forLinks(attribute, [&](std::string_view link) {
      const std::string one = componentLink(element, *data, std::string(link));
      if (!one.empty()) value += (value.empty() ? "" : " ") + one;
      if (one.empty()) tell(std::string(link), nowhere);
    });
    if (value.empty()) return broken.push_back(attribute.name);
  } else if (!many) {
    const LinkTarget target = tree_->follow(element, text, true);
    if (isEmptyList(target)) return breaks("leads to a list that is empty in SOFA");
    if (isVelocityOfFile(target)) return breaks("leads to a loader, which has no velocities in SOFA either");
    value = dataLink(element, attribute);
  } else {  // several components in a list of words
    Words words(text);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const LinkTarget target = tree_->follow(element, word, false);
      Element* found = target.element ? target.element : target.place ? target.place->firstOf("mechanical state") : nullptr;
      value += (value.empty() ? "" : " ") + (found ? SceneTree::linkTo(*found) : std::string(word));
    }
  }
  if (value.empty()) return breaks(nowhere);
  attribute.value = value;
}

/// The component meant by a place: the only one that fits, else its state or its topology, else the first that fits.
Element* Rewriting::meant(const Element& asker, const LinkTarget& target, const LinkBase& wanted) const {
  if (!target.place) return target.element;
  std::vector<Element*> fitting;
  for (const auto& element : target.place->elements)
    if (!element->dropped && element->probe && element.get() != &asker && wanted.accepts(*element->probe))
      fitting.push_back(element.get());
  if (fitting.empty()) return nullptr;
  for (Element* element : fitting)
    if (fitting.size() > 1 && element->role() != "topological mapping") return element;
  return fitting.front();
}

std::string Rewriting::componentLink(Element& element, const Data& data, const std::string& text) {
  const LinkBase& link = *data.link();
  LinkTarget target = tree_->follow(element, text, false);
  if (!target.element && !target.place) target = tree_->follow(element, text, true);
  if (target.element && !target.element->probe && !target.element->without_effect) return text;  // reported by itself
  Element* found = meant(element, target, link);
  if (!found || found->dropped || !found->probe) return {};
  if (!link.accepts(*found->probe)) {
    // a component of another class: SOFA falls back to the node's
    found = meant(element, {nullptr, found->place, {}}, link);
    if (!found) return {};
  }
  return SceneTree::linkTo(*found);
}

/// Edges and sides of its cells, which SOFA's topologies list from the start: here where somebody reads them.
void Rewriting::listParts(Element& mesh, const std::string& list) {
  const bool is_grid = mesh.is("RegularGridTopology");
  const bool has_cells = is_grid || mesh.find("tetrahedra") || mesh.find("hexahedra") || mesh.find("triangles") || mesh.find("quads") ||
                         mesh.find("src") || mesh.find("filename");
  if (!(is_grid || mesh.is("MeshTopology") || mesh.written->type.ends_with("SetTopologyContainer")) || !has_cells || mesh.find(list))
    return;
  if (is_grid && isAnyOf(list, {"edges", "triangles", "quads"}))  // edges are those of the triangles too
    for (const char* flag : {"computeEdgeList", "computeTriangleList", "computeQuadList"}) setDefault(mesh, flag, "true");
  if (is_grid) return;
  if (list == "edges") setDefault(mesh, "createEdgeArray", "true");
  if (list == "triangles") setDefault(mesh, "createTriangleArray", "true");
  if (list == "quads") setDefault(mesh, "createQuadArray", "true");
}

/// The same for what a region chooses of them: `data` as triangleIndices, trianglesInROI or trianglesOutROI.
void Rewriting::listPartsOfRegion(const Element& region, const std::string& data) {
  for (const std::string one : {"edge", "triangle", "quad"})
    if (data.starts_with(one) && !region.find(one + "s"))
      if (Element* mesh = meshOf(region)) listParts(*mesh, one + "s");
}

std::string Rewriting::dataLink(Element& element, const AttributeDescription& attribute) {
  const std::string text(trimmed(attribute.value));
  LinkTarget target = tree_->follow(element, text, true);
  const std::string data = target.data.empty() ? element.probe->data().find(attribute.name)->name() : target.data;
  if (target.place)
    for (const auto& each : target.place->elements)
      if (!target.element && !each->dropped && each->probe && each->probe->data().find(data)) target.element = each.get();
  if (!target.element) return {};
  if (!target.element->probe) return target.element->without_effect ? std::string() : text;
  if (target.element->dropped) return {};
  // what a mapping was given may be read before the mapping has its output, which is the asker
  if (element.role() == "mechanical state" && target.element->role() == "mapping" && target.element->place == element.place)
    if (const std::string given = target.element->text(data); !given.empty() && !given.starts_with("@")) return given;
  warnOfMoving(element, attribute, *target.element, data), listParts(*target.element, data);
  if (target.element->role() == "selection") listPartsOfRegion(*target.element, data);
  const bool is_surface = target.element->is("GenerateCylinder") && data == "triangles";  // of nodes of its own
  return SceneTree::linkTo(*target.element) + "." + (is_surface ? "surfaceTriangles" : data);
}

/// SOFA's engines follow what they read; here they run once, before the first step.
void Rewriting::warnOfMoving(const Element& element, const AttributeDescription& attribute, const Element& source,
                             const std::string& data) {
  const std::string role = element.role();
  const bool runs_once = role == "engine" || role == "selection" || role == "mesh engine";
  if (!runs_once || source.role() != "mechanical state" || (data != "position" && data != "velocity")) return;
  if (saysNo(element.text("doUpdate"))) return;
  warn(attribute.where, element, attribute.name,
       "is read once, where the scene starts: in SOFA " + element.written->type + " follows " + source.path() + " as it moves",
       data == "position" ? "@" + source.path() + ".rest_position, if that is meant" : "");
}

/// Cells of a region that name nodes by their places in it: a MeshSubsetEngine has them.
void Rewriting::renumberPart(Element& region) {
  const SourceLocation& where = region.written->where;
  const std::string link = SceneTree::linkTo(region) + ".", name = region.name + "_part";
  const std::string engine = "@" + joinPath(region.place->path(), name) + ".";
  std::set<std::string> kinds;
  tree_->forEach([&](Element& element) {
    for (AttributeDescription& attribute : element.written->attributes) {
      if (!trimmed(attribute.value).starts_with(link)) continue;
      std::string data(trimmed(attribute.value).substr(link.size()));
      const bool is_in = data.ends_with("InROI");
      const bool is_cells = isAnyOf(data.substr(0, data.find(is_in ? "InROI" : "OutROI")),
                                    {"edges", "triangles", "quads", "tetrahedra", "hexahedra"});
      if (!is_cells || (!is_in && !data.ends_with("OutROI"))) continue;
      if (!is_in || saysNo(region.text("strict")))
        return diagnostics_.error(attribute.where, element.path() + "." + attribute.name,
                                  "the cells outside of a region, or with nodes outside, keep the numbers of the whole here",
                                  "localIndices=\"false\" of " + region.path());
      data.resize(data.size() - std::string_view("InROI").size());
      kinds.insert(data);
      attribute.value = engine + data;
    }
  });
  if (kinds.empty()) return;
  Element* mesh = meshOf(region);
  const auto source = [&](const std::string& list) {
    const Data* data = region.probe->data().find(list);
    for (const AttributeDescription& attribute : region.written->attributes)
      if (region.probe->data().find(attribute.name) == data) return attribute.value;
    return mesh ? SceneTree::linkTo(*mesh) + "." + list : std::string();
  };
  ComponentDescription part{"MeshSubsetEngine", {{"name", name, where}, {"indices", link + "indices", where}}, where,
                            region.written->folder};
  part.attributes.push_back({"inputPosition", source("position"), where});
  for (const std::string& kind : kinds)
    part.attributes.push_back({std::string("input") + char(std::toupper(static_cast<unsigned char>(kind[0]))) + kind.substr(1),
                               source(kind), where});
  region.place->added_components.push_back(std::move(part));
}

}  // namespace stroma::sofa
