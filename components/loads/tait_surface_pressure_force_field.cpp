// SPDX-License-Identifier: LGPL-2.1-or-later
// TaitSurfacePressureForceField: a liquid or a gas behind a closed surface, by Tait's equation.
//
//   p = p0 - B ((V / V_0)^gamma - 1),   f_a = p A_a   on all triangles and quads of the mesh
//   E = -(p0 + B) V + B V_0 / (gamma + 1) (V / V_0)^(gamma + 1),   dE/dV = -p
//
// V is the volume inside the surface, A_a the area vector of a node; V_0 is the rest volume plus injectedVolume, immediately,
// or with a maxInjectionRate q gradually from t = 0 on: min(injectedVolume, q t). B and gamma define the stiffness of the
// content (water: gamma 7). The tangent is the derivative,
//
//   K_ab = p dA_a/dx_b + p' A_a A_b^T,   p' = dp/dV = -B gamma (V / V_0)^gamma / V
//
// whose second part couples all nodes of the surface. An assembled matrix has it up to a thousand nodes, products always.
//
// Source: P. G. Tait 1888; names and attributes are SOFA's, as is the tangent.
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

#include <algorithm>
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
    table.add("maxInjectionRate", rate_).recompiled().help("how fast it comes in; 0: at once").unit("m^3/s").min(0);
    for (const char* name : {"drawForceScale", "drawForceColor", "initialVolume", "currentInjectedVolume", "v0", "currentVolume",
                             "currentPressure", "currentStiffness", "initialSurfaceArea", "currentSurfaceArea",
                             "pressureTriangles", "volumeAfterTC", "surfaceAreaAfterTC"})
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
      throw ComponentError(fmt::format("the surface is open at the edge of nodes {}, so it encloses no volume", openEdge()),
                           "a closed surface");
    for (const double in : {0., injected_})
      if (volume_ = restVolume() + in; !(volume_ > 0))
        throw ComponentError(fmt::format("the volume behind the surface is {:g} with {:g} injected", volume_, in),
                             "normals that point outward, and a positive volume");
    if (rate_ > 0) setTime(0);
    nodes_.clear();
    for (const Face& face : this->faces()) nodes_.insert(nodes_.end(), face.nodes.begin(), face.nodes.begin() + face.corners);
    std::sort(nodes_.begin(), nodes_.end());
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    if (!isAssembled())
      inform(fmt::format("with more than {} nodes an assembled matrix takes the pressure as it is, and Newton's method may take "
                         "many iterations with it: CGLinearSolver takes products, which know how it falls", most_assembled));
  }
  ForceTraits traits() const override {
    ForceTraits traits = SurfaceLoad::traits();
    traits.exact_tangent = isAssembled();
    traits.time_dependent = rate_ > 0;
    return traits;
  }
  void setTime(double t) override {
    if (rate_ > 0) volume_ = restVolume() + std::copysign(std::min(std::abs(injected_), rate_ * std::max(t, 0.)), injected_);
  }
  void compile() override {
    SurfaceLoad::compile();
    slope_.assign(std::size_t(state().firstRow() + state().nodes()), Vec3::Zero());
    fall_ = 0;
  }
  double energy(ConstRows x) const override {
    const double v = volume(x), grown = std::pow(std::max(v, 0.) / volume_, exponent_ + 1);
    return -(pressure_ + bulk_) * v + (exponent_ == -1 ? 0 : bulk_ * volume_ / (exponent_ + 1) * grown);
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    SurfaceLoad::addForce(x, v, f);
    const double now = volume(x);
    fall_ = now > 0 ? -bulk_ * exponent_ * std::pow(now / volume_, exponent_) / now : 0;
    if (fall_ == 0) return;
    for (const Index node : nodes_) slope_[std::size_t(row(node))].setZero();
    for (const Face& face : faces()) {
      area_vectors::Corners at;
      for (std::size_t a = 0; a < at.size(); ++a) at[a] = x[row(face.nodes[a])];
      const area_vectors::Corners areas = area_vectors::of(at, face.corners);
      for (int a = 0; a < face.corners; ++a) slope_[std::size_t(row(face.nodes[std::size_t(a)]))] += areas[std::size_t(a)];
    }
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    SurfaceLoad::addStiffnessProduct(dx, factor, df);
    if (fall_ == 0) return;
    double change = 0;
    for (const Index node : nodes_) change += slope(node).dot(dx[row(node)]);
    for (const Index node : nodes_) df[row(node)] += factor * fall_ * change * slope(node);
  }
  void addPattern(BlockPattern& pattern) const override {
    SurfaceLoad::addPattern(pattern);
    if (!isAssembled()) return;
    std::vector<Index> rows;
    for (const Index node : nodes_) rows.push_back(row(node));
    pattern.addClique(rows.data(), int(rows.size()));
  }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    SurfaceLoad::addStiffness(factor, matrix);
    if (fall_ == 0 || !isAssembled()) return;
    for (const Index a : nodes_)
      for (const Index b : nodes_) matrix.add(row(a), row(b), factor * fall_ * slope(a) * slope(b).transpose());
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    SurfaceLoad::addStiffnessDiagonal(factor, blocks);
    if (fall_ == 0 || !isAssembled()) return;
    for (const Index node : nodes_)
      for (int k = 0; k < 9; ++k)
        blocks[std::size_t(row(node)) * 9 + std::size_t(k)] += factor * fall_ * slope(node)[k / 3] * slope(node)[k % 3];
  }

 protected:
  Mat3 stress(ConstRows x) const override {
    const double share = std::max(volume(x), 0.) / volume_;
    return (pressure_ - bulk_ * (std::pow(share, exponent_) - 1)) * Mat3::Identity();
  }
  bool hasPotential() const override { return true; }

 private:
  static constexpr std::size_t most_assembled = 1000;  ///< nodes: a million blocks
  bool isAssembled() const { return nodes_.size() <= most_assembled; }
  Index row(Index node) const { return state().firstRow() + node; }
  const Vec3& slope(Index node) const { return slope_[std::size_t(row(node))]; }

  double pressure_ = 0, bulk_ = 0, exponent_ = 0, injected_ = 0, rate_ = 0;
  double volume_ = 1;         ///< V_0 [m^3]
  std::vector<Index> nodes_;  ///< of the surface
  std::vector<Vec3> slope_;   ///< dV/dx by rows of the system [m^2]
  double fall_ = 0;           ///< p' of the last force [Pa/m^3]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(tait_surface_pressure_force_field) {
  factory.add<stroma::TaitSurfacePressureForceField>("TaitSurfacePressureForceField", "a liquid or gas behind a closed surface");
}
