// SPDX-License-Identifier: LGPL-2.1-or-later
// Capsules and boxes, which were collision models of SOFA once: surfaces that the frames carry, and lines with their radius about them.
//
//   capsule of a frame: the line from -h/2 to h/2 of the frame's y, with the radius r as contactDistance
//   capsule of points:  the lines of the mesh, with r
//   box of a frame:     its eight corners, at plus and minus the extents
//
// Radii, heights and extents are lists, one for each frame, and where a list ends the default counts. Of a line a radius is that of
// the whole model: capsules with another one are a model of their own.
#include <algorithm>
#include <map>

#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

std::string textOf(const ComponentDescription& solid, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const AttributeDescription* found = solid.find(name)) return found->value;
  return {};
}

double numberOf(const ComponentDescription& solid, std::initializer_list<const char*> names, double otherwise) {
  const std::vector<double> numbers = writtenNumbers(textOf(solid, names));
  return numbers.empty() ? otherwise : numbers[0];
}

/// The points, and the cells of them, of solids of several frames.
struct Skin {
  std::string position, cells, frames;
  std::size_t points = 0;

  void add(std::size_t frame, const std::vector<Vec3>& corners, const std::vector<std::size_t>& of_cells) {
    for (const std::size_t node : of_cells) cells += std::to_string(points + node) + " ";
    for (const Vec3& p : corners) {
      position += printed({p[0], p[1], p[2]}) + "  ";
      frames += std::to_string(frame) + " ";
    }
    points += corners.size();
  }
};

ComponentDescription part(const ComponentDescription& solid, const char* type,
                          const std::vector<std::pair<const char*, std::string>>& attributes) {
  ComponentDescription made{type, {}, solid.where, solid.folder};
  for (const auto& [name, value] : attributes) made.attributes.push_back({name, value, solid.where});
  return made;
}

/// A model with what SOFA's collision models have in common, and a skin of that thickness.
ComponentDescription model(const ComponentDescription& solid, const char* type, double radius) {
  ComponentDescription made = part(solid, type, {});
  for (const char* kept : {"active", "moving", "simulated", "selfCollision", "group", "contactStiffness", "contactFriction",
                           "contactRestitution", "contactResponse", "tags"})
    if (const AttributeDescription* found = solid.find(kept)) made.attributes.push_back(*found);
  const double skin = numberOf(solid, {"contactDistance", "proximity"}, 0) + radius;
  if (skin > 0) made.attributes.push_back({"contactDistance", printed({skin}), solid.where});
  return made;
}

NodeDescription skinNode(const ComponentDescription& solid, const std::string& name, const char* cells, const Skin& skin,
                         const std::vector<const char*>& models, double radius) {
  NodeDescription node;
  node.where = solid.where;
  node.attributes.push_back({"name", name, solid.where});
  node.components.push_back(part(solid, "MeshTopology", {{"name", "mesh"}, {"position", skin.position}, {cells, skin.cells}}));
  node.components.push_back(part(solid, "MechanicalObject", {{"name", "points"}, {"position", skin.position}}));
  for (const char* type : models) node.components.push_back(model(solid, type, radius));
  node.components.push_back(part(solid, "RigidMapping", {{"rigidIndexPerPoint", skin.frames}}));
  return node;
}

bool isCapsule(const ComponentDescription& each) {
  return isAnyOf(each.type, {"CapsuleCollisionModel", "CapsuleModel", "TCapsuleModel", "Capsule", "RigidCapsuleCollisionModel",
                              "RigidCapsuleModel", "RigidCapsule"});
}
bool isBox(const ComponentDescription& each) { return isAnyOf(each.type, {"OBBCollisionModel", "OBBModel", "TOBBModel", "OBB"}); }
bool isTrianglesMethod(const ComponentDescription& each) { return each.type == "NewProximityIntersection"; }
bool isState(const ComponentDescription& each) { return isAnyOf(each.type, {"MechanicalObject", "MappedObject"}); }

template <class Test>
bool holdsAny(const NodeDescription& node, Test&& test) {
  return std::any_of(node.components.begin(), node.components.end(), test) ||
         std::any_of(node.children.begin(), node.children.end(), [&](const auto& child) { return holdsAny(child, test); });
}

/// How many frames a state writes; none: it has points.
std::size_t framesOf(const ComponentDescription& state) {
  if (!textOf(state, {"template"}).starts_with("Rigid")) return 0;
  return std::max<std::size_t>(1, writtenNumbers(textOf(state, {"position"})).size() / 7);
}

}  // namespace

/// `with_triangles`: the method lets triangles meet what lines and points meet too, so that these would be met twice.
static void addCapsules(NodeDescription& node, const ComponentDescription& solid, const std::string& name, std::size_t frames,
                        bool with_triangles) {
  const std::vector<double> radii = writtenNumbers(textOf(solid, {"radii", "listCapsuleRadii"}));
  const std::vector<double> heights = writtenNumbers(textOf(solid, {"heights"}));
  std::map<double, Skin> by_radius;
  for (std::size_t i = 0; i < std::max({frames, radii.size(), heights.size()}); ++i) {
    const double half = (i < heights.size() ? heights[i] : numberOf(solid, {"defaultHeight"}, 2)) / 2;
    by_radius[i < radii.size() ? radii[i] : numberOf(solid, {"defaultRadius"}, 0.5)].add(i, {{0, -half, 0}, {0, half, 0}}, {0, 1});
  }
  std::vector<const char*> models{"LineCollisionModel"};
  if (!with_triangles) models.push_back("PointCollisionModel");
  int count = 0;
  for (const auto& [radius, skin] : by_radius)
    node.children.push_back(skinNode(solid, name + "_skin" + (count++ > 0 ? std::to_string(count) : ""), "edges", skin, models, radius));
}

/// Of the lines of a mesh, which are one model with one radius.
static ComponentDescription capsulesOfPoints(const ComponentDescription& solid, const std::string& path, Diagnostics& diagnostics) {
  const std::vector<double> radii = writtenNumbers(textOf(solid, {"listCapsuleRadii", "radii"}));
  const double radius = radii.empty() ? numberOf(solid, {"defaultRadius"}, 0.5) : radii[0];
  if (std::any_of(radii.begin(), radii.end(), [radius](double each) { return each != radius; }))
    diagnostics.warning(solid.where, path, "has lines of several radii: all have the first one here, " + printed({radius}));
  ComponentDescription made = model(solid, "LineCollisionModel", radius);
  if (const AttributeDescription* name = solid.find("name")) made.attributes.push_back(*name);
  return made;
}

static void addBoxes(NodeDescription& node, const ComponentDescription& solid, const std::string& name, std::size_t frames,
                     bool with_triangles) {
  static const std::vector<std::size_t> sides = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                                 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  const std::vector<double> extents = writtenNumbers(textOf(solid, {"extents"}));
  const double usual = numberOf(solid, {"defaultExtent"}, 1);
  Skin skin;
  for (std::size_t i = 0; i < std::max(frames, extents.size() / 3); ++i) {
    const Vec3 half = 3 * i + 3 <= extents.size() ? Vec3(extents[3 * i], extents[3 * i + 1], extents[3 * i + 2]) : Vec3::Constant(usual);
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k) corners.push_back(half.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
    skin.add(i, corners, sides);
  }
  std::vector<const char*> models{"TriangleCollisionModel"};
  if (!with_triangles) models.insert(models.end(), {"LineCollisionModel", "PointCollisionModel"});
  node.children.push_back(skinNode(solid, name + "_skin", "triangles", skin, models, 0));
}

void Rewriting::expandSolids() {
  if (!holdsAny(scene_.root, [](const auto& each) { return isCapsule(each) || isBox(each); })) return;
  has_solids_ = true;
  const bool with_triangles = holdsAny(scene_.root, isTrianglesMethod);
  const auto expand = [&](const auto& self, NodeDescription& node, const std::string& path, std::size_t frames) -> void {
    for (const ComponentDescription& each : node.components)
      if (isState(each)) frames = framesOf(each);
    std::vector<ComponentDescription> kept;
    const std::size_t children = node.children.size();
    int count = 0;
    for (ComponentDescription& each : node.components) {
      if (!isCapsule(each) && !(isBox(each) && frames > 0)) {
        kept.push_back(std::move(each));
        continue;
      }
      const std::string name = each.name().empty() ? each.type + std::to_string(++count) : each.name();
      diagnostics_.warning(each.where, joinPath(path, name),
                           std::string("is ") + (isBox(each) ? "a surface of triangles" : "a line with a skin of its radius") +
                               " here: contacts are those of its corners and edges, in SOFA of the nearest points of the solids");
      if (isBox(each))
        addBoxes(node, each, name, frames, with_triangles);
      else if (frames > 0)
        addCapsules(node, each, name, frames, with_triangles);
      else
        kept.push_back(capsulesOfPoints(each, joinPath(path, name), diagnostics_));
    }
    node.components = std::move(kept);
    const std::vector<std::string> names = childNames(node);
    for (std::size_t i = 0; i < children; ++i) self(self, node.children[i], joinPath(path, names[i]), frames);
  };
  expand(expand, scene_.root, "/", 0);
}

}  // namespace stroma::sofa
