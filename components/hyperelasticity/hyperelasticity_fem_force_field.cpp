// SPDX-License-Identifier: LGPL-2.1-or-later
// Hyperelastic cells of the kind that the mesh holds, or of the one that template="Vec3,Tetrahedron", "Vec3,Hexahedron" or
// "Vec3,QuadraticTetrahedron" names, whose law is a component of its own: NeoHookeanMaterial, StVenantKirchhoffMaterial,
// MooneyRivlinMaterial, OgdenMaterial or IncompressibleMooneyRivlinMaterial, on whose page the formulas are. `material` names
// it; without that it is the one in the node of the field, or else in the nearest node above.
//
// What is computed and how is on the pages of TetrahedronHyperelasticityFEMForceField, HexahedronHyperelasticityFEMForceField
// and QuadraticTetrahedronHyperelasticityFEMForceField: forces f_a = -sum_p w_p F_p S_p grad N_a at one, eight or four points p,
// and their exact tangent. dilatation, projectedTangent and viscosity are theirs too. dilatation = local is what SOFA computes.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.04"/>
//   <NeoHookeanMaterial name="tissue" youngModulus="2e4" poissonRatio="0.45"/>
//   <HyperelasticityFEMForceField template="Vec3,Hexahedron" material="@tissue"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "components/hyperelasticity/hyperelastic_material.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/names.h"

namespace stroma {
namespace {

constexpr const CellKind* served[] = {&cell_kinds::tetrahedron, &cell_kinds::hexahedron, &cell_kinds::quadratic_tetrahedron};

class HyperelasticityFEMForceField final : public HyperelasticForceField {
 public:
  void declare(DataTable& table) override {
    declareMesh(table);
    table.addLink("material", material_).help("the law and its parameters; empty: that of this node, or of the nearest one above");
    declareMethod(table);
  }

 private:
  void chooseMesh() override {
    chooseKind();
    HyperelasticForceField::chooseMesh();
  }
  void chooseLaw() override {
    HyperelasticMaterial* material = material_.get();
    if (!material) material = find<HyperelasticMaterial>(true);
    if (!material)
      throw ComponentError("there is no material in this node or above",
                           "NeoHookeanMaterial, StVenantKirchhoffMaterial, MooneyRivlinMaterial, OgdenMaterial or "
                           "IncompressibleMooneyRivlinMaterial beside this field, or material=\"@...\"",
                           "materialName of Tetrahedron- or HexahedronHyperelasticityFEMForceField has more laws");
    law_ = material->law();
    parameter_set_ = material->values();
    material->follow(*this, [this] { makeAnew(); });
  }
  /// The material has other parameters while the scene runs: what steps have left behind stays.
  void makeAnew() {
    Archive memory;
    serialize(memory);
    recompile(), compile();
    memory = memory.readable();
    serialize(memory);
  }
  /// Where no mesh holds anything of it, the base says so.
  void chooseKind();

  Link<HyperelasticMaterial> material_{"hyperelastic material"};
};

void HyperelasticityFEMForceField::chooseKind() {
  std::vector<std::string> words, plurals;
  for (const CellKind* each : served) {
    words.push_back(fmt::format("Vec3,{}", each->word));
    plurals.emplace_back(each->plural);
  }
  const auto comma = template_.find(',');
  const std::string vector = template_.substr(0, comma), wanted = comma == std::string::npos ? "" : template_.substr(comma + 1);
  const auto is_wanted = [&](const CellKind* each) { return each->word == wanted; };
  const bool is_known = wanted.empty() || std::any_of(std::begin(served), std::end(served), is_wanted);
  if (!is_known || (!vector.empty() && vector != "Vec3" && vector != "Vec3d" && vector != "Vec3f"))
    throw ComponentError(fmt::format("template '{}' is none that {} has", template_, type()),
                         fmt::format("Vec3, {}", fmt::join(words, ", ")), nearest(template_, words));
  const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
  if (!topology) return;
  std::vector<const CellKind*> found;
  forEachCellList(
      [&](const CellKind& of, const auto& cells) {
        for (const CellKind* each : served)
          if (each->type == of.type && !cells.empty() && (wanted.empty() || is_wanted(each))) found.push_back(each);
      },
      topology->mesh());
  if (found.size() > 1)
    throw ComponentError(fmt::format("{} holds {}", topology->path(), fmt::join(plurals, " and ")),
                         "one force field for each kind of cell",
                         fmt::format("template=\"{}\"", fmt::join(words, "\" or template=\"")));
  if (found.empty() && wanted.empty())
    throw ComponentError(fmt::format("{} holds no {}", topology->path(), fmt::join(plurals, " and no ")),
                         fmt::format("a mesh of {}", fmt::join(plurals, " or ")));
  for (const CellKind* each : served)
    if (is_wanted(each) || (!found.empty() && found[0] == each)) kind = each;
}

}  // namespace
}  // namespace stroma

using namespace stroma;

STROMA_COMPONENT(hyperelasticity_fem_force_field) {
  factory.add<HyperelasticityFEMForceField>("HyperelasticityFEMForceField",
                                            "hyperelastic cells of the kind that the mesh holds, with a material beside them");
}
