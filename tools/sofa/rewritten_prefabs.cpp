// SPDX-License-Identifier: LGPL-2.1-or-later
// SOFA's prefabs, which lie as files Objects/NAME.xml beside its examples: where a scene brings no such file they are written out.
#include <algorithm>
#include <iterator>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

using Attributes = std::vector<AttributeDescription>;

/// Attributes of the prefab replace what its parts write. Others are the linear solver's, or else the integrator's, which tells those
/// that it does not know; so is the name.
void handOn(const Attributes& given, ComponentDescription& integrator, ComponentDescription& solver) {
  const auto replace = [](ComponentDescription& part, const AttributeDescription& other) {
    bool is_written = false;
    for (AttributeDescription& attribute : part.attributes)
      if (attribute.name == other.name) attribute = other, is_written = true;
    return is_written;
  };
  for (const AttributeDescription& attribute : given) {
    const bool in_integrator = replace(integrator, attribute), in_solver = replace(solver, attribute);
    if (in_integrator || in_solver) continue;
    (attribute.name == "warmStart" ? solver : integrator).attributes.push_back(attribute);
  }
}

ComponentDescription partOf(const ComponentDescription& prefab, const char* type,
                            std::initializer_list<std::pair<const char*, std::string>> attributes) {
  ComponentDescription part{type, {}, prefab.where, prefab.folder};
  for (const auto& [name, value] : attributes) part.attributes.push_back({name, value, prefab.where});
  return part;
}

}  // namespace

std::string_view loaderOf(std::string_view file) {
  static const std::vector<std::pair<std::string_view, std::string_view>> loaders = {
      {".msh", "MeshGmshLoader"}, {".obj", "MeshOBJLoader"}, {".stl", "MeshSTLLoader"},
      {".vtk", "MeshVTKLoader"},  {".vtu", "MeshVTKLoader"}, {".off", "MeshOffLoader"},
      {".xs3", "MeshXspLoader"},  {".xsp", "MeshXspLoader"}, {".trian", "MeshTrianLoader"},
      {".gid", "GIDMeshLoader"}};
  for (const auto& [ending, type] : loaders)
    if (file.ends_with(ending)) return type;
  return {};
}

/// Names that SOFA's components had beside their own until 24.12; a MasterContactSolver, older still, found the forces of contacts.
static void renameOld(std::vector<ComponentDescription>& components) {
  static const std::vector<std::pair<std::string_view, const char*>> names = {
      {"MasterSolver", "DefaultAnimationLoop"}, {"DefaultMasterSolver", "DefaultAnimationLoop"},
      {"DefaultAnimationMasterSolver", "DefaultAnimationLoop"}, {"FreeMotionMasterSolver", "FreeMotionAnimationLoop"},
      {"MultiStepMasterSolver", "MultiStepAnimationLoop"}, {"MultiTagMasterSolver", "MultiTagAnimationLoop"},
      {"MasterConstraintSolver", "ConstraintAnimationLoop"}, {"MasterContactSolver", "LCPConstraintSolver"},
      {"DampVelocity", "DampVelocitySolver"}, {"VariationalSolver", "VariationalSymplecticSolver"},
      {"SphereQuad", "SphereQuadTopology"}, {"CylinderGrid", "CylinderGridTopology"}, {"SphereGrid", "SphereGridTopology"},
      {"SparseGridMultiple", "SparseGridMultipleTopology"}, {"SparseGridRamification", "SparseGridRamificationTopology"},
      {"SVDLinear", "SVDLinearSolver"}, {"SVD", "SVDLinearSolver"}, {"MINRESSolver", "MinResLinearSolver"},
      {"MinResSolver", "MinResLinearSolver"}, {"JacobiLinearSolver", "JacobiPreconditioner"},
      {"JacobiSolver", "JacobiPreconditioner"}, {"SSORLinearSolver", "SSORPreconditioner"}, {"SSORSolver", "SSORPreconditioner"},
      {"RigidEngine", "RigidToQuatEngine"}, {"RuleBasedCollisionResponse", "RuleBasedContactManager"},
      {"SurfaceIdentityMapping", "SubsetMapping"}, {"ObjExporter", "OBJExporter"}};
  std::vector<ComponentDescription> added;
  for (ComponentDescription& component : components)
    for (const auto& [old, present] : names)
      if (component.type == old) {
        if (old == "MasterContactSolver") added.push_back(partOf(component, "FreeMotionAnimationLoop", {}));
        component.type = present;
        break;
      }
  std::move(added.begin(), added.end(), std::back_inserter(components));
}

/// BoxConstraint and CGImplicit; and the old MeshLoader, which took files of any format.
void Rewriting::expandPrefabs() {
  int count = 0;
  const auto expand = [&](const auto& self, NodeDescription& node) -> void {
    std::vector<ComponentDescription> components;
    renameOld(node.components);
    for (ComponentDescription& component : node.components) {
      const bool selects = component.type == "BoxConstraint" || component.type == "FixedBoxConstraint";
      const bool solves = component.type == "CGImplicit" || component.type == "CGImplicitSolver";
      if (const AttributeDescription* file = component.find("filename"); component.type == "MeshLoader" && file)
        if (const std::string_view type = loaderOf(trimmed(file->value)); !type.empty()) component.type = std::string(type);
      if (!selects && !solves) {
        components.push_back(std::move(component));
        continue;
      }
      const std::string what = selects ? "a BoxROI and a FixedProjectiveConstraint" : "an EulerImplicitSolver and a CGLinearSolver";
      diagnostics_.note(component.where, component.type, "is a prefab of SOFA: " + what);
      if (selects) {
        const AttributeDescription* given = component.find("name");
        const std::string name = given ? given->value : "BoxConstraint" + std::to_string(++count);
        ComponentDescription fixed = partOf(component, "FixedProjectiveConstraint", {{"indices", "@" + name + ".indices"}});
        if (!given) component.attributes.push_back({"name", name, component.where});
        component.type = "BoxROI";
        components.push_back(std::move(component));
        components.push_back(std::move(fixed));
      } else {
        ComponentDescription euler =
            partOf(component, "EulerImplicitSolver", {{"rayleighStiffness", "0.1"}, {"rayleighMass", "0.1"}});
        ComponentDescription solver =
            partOf(component, "CGLinearSolver", {{"iterations", "25"}, {"tolerance", "1e-5"}, {"threshold", "1e-5"}});
        handOn(component.attributes, euler, solver);
        components.push_back(std::move(euler));
        components.push_back(std::move(solver));
      }
    }
    node.components = std::move(components);
    for (NodeDescription& child : node.children) self(self, child);
  };
  expand(expand, scene_.root);
}

}  // namespace stroma::sofa
