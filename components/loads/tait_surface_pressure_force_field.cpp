// SPDX-License-Identifier: LGPL-2.1-or-later
// TaitSurfacePressureForceField: a liquid or a gas behind a closed surface, by Tait's equation.
//
//   p = p0 - B ((V / V_0)^gamma - 1),   f_a = p A_a   on all triangles and quads of the mesh
//   E = -(p0 + B) V + B V_0 / (gamma + 1) (V / V_0)^(gamma + 1),   dE/dV = -p
//
// V is the volume behind the surface, A_a the area vector of a node; V_0 is the volume at rest plus injectedVolume. B and gamma
// say how stiff the content is (water: gamma 7). The tangent is that of a fixed pressure: what p gains by the change
// of V couples all nodes, and is left out.
//
// Source: P. G. Tait 1888; names and attributes are SOFA's, whose tangent this is too. There the injected volume comes in at
// most at maxInjectionRate, here at once.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <MeshSpringForceField trianglesStiffness="500"/>
//   <TaitSurfacePressureForceField p0="50" B="1" gamma="2" injectedVolume="0.02"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/loads/surface_load.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TaitSurfacePressureForceField final : public SurfaceLoad {
 public:
  void declare(DataTable& table) override {
    SurfaceLoad::declare(table);
    table.add("p0", pressure_).recompiled().help("pressure at V_0").unit("Pa");
    table.add("B", bulk_).recompiled().help("how much it falls where the volume grows").unit("Pa").min(0);
    table.add("gamma", exponent_).recompiled().help("exponent").unit("-");
    table.add("injectedVolume", injected_).recompiled().help("more than the volume at rest").unit("m^3");
    for (const char* name : {"drawForceScale", "drawForceColor", "initialVolume", "currentInjectedVolume", "v0", "currentVolume",
                             "currentPressure", "currentStiffness", "initialSurfaceArea", "currentSurfaceArea",
                             "pressureTriangles", "maxInjectionRate", "volumeAfterTC", "surfaceAreaAfterTC"})
      table.addVisualOnly(name);
  }
  void init() override {
    ForceField::init();
    const Mesh& mesh = surfaceMesh();
    std::vector<Face> faces(mesh.triangles.begin(), mesh.triangles.end());
    for (const Quad& quad : mesh.quads) faces.emplace_back(quad);
    if (faces.empty()) throw ComponentError("the mesh has no triangles and no quads", "a closed surface");
    setFaces(std::move(faces));
    stress_is_fixed = false;
    if (!isClosed())
      throw ComponentError(fmt::format("the surface is open at the edge of nodes {}, so it holds no volume", openEdge()),
                           "a closed surface");
    volume_ = restVolume() + injected_;
    if (!(volume_ > 0))
      throw ComponentError(fmt::format("the volume behind the surface is {:g} with {:g} injected", volume_, injected_),
                           "normals that point outward, and a positive volume");
  }
  double energy(ConstRows x) const override {
    const double v = volume(x), grown = std::pow(std::max(v, 0.) / volume_, exponent_ + 1);
    return -(pressure_ + bulk_) * v + (exponent_ == -1 ? 0 : bulk_ * volume_ / (exponent_ + 1) * grown);
  }

 protected:
  Mat3 stress(ConstRows x) const override {
    const double share = std::max(volume(x), 0.) / volume_;
    return (pressure_ - bulk_ * (std::pow(share, exponent_) - 1)) * Mat3::Identity();
  }
  bool hasPotential() const override { return true; }

 private:
  double pressure_ = 0, bulk_ = 0, exponent_ = 0, injected_ = 0;
  double volume_ = 1;  ///< V_0 [m^3]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(tait_surface_pressure_force_field) {
  factory.add<stroma::TaitSurfacePressureForceField>("TaitSurfacePressureForceField", "a liquid or gas behind a closed surface");
}
