// SPDX-License-Identifier: LGPL-2.1-or-later
// TrianglePressureForceField: a force per area on triangles that keeps its direction, or a stress that follows them.
//
//   useConstantForce = true:    f_a = A_0/3 pressure for each corner of a triangle, A_0 its area at rest;
//                               E = -sum f_a . x_a, K = 0
//   useConstantForce = false:   f_a = sigma A_a, A_a = (x_1 - x_0) x (x_2 - x_0) / 6; no potential
//
// The first is a dead load: it does not follow the area or the normal. The second is the traction sigma n of a body with the
// Cauchy stress sigma on the current surface; uniform on a closed one, it has no resultant and no moment. cauchyStress lists
// xx xy yy zx yz zz. tangent (of the second) is exact, or its symmetric part, which is approximate;
// useTangentStiffness="false": none, as in SOFA.
//
// Source: the names and attributes are SOFA's, but tangent.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <MeshSpringForceField linesStiffness="500"/>
//   <TrianglePressureForceField triangleList="1" useConstantForce="false" cauchyStress="3 1 -2 0.5 0 4"
//     tangent="exact"/>
//   <TrianglePressureForceField triangleList="0 1" pressure="0 1 4"/>
// </Node>
#include <fmt/format.h>

#include "components/loads/surface_load.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TrianglePressureForceField final : public SurfaceLoad {
 public:
  void declare(DataTable& table) override {
    SurfaceLoad::declare(table);
    table.add("pressure", pressure_).recompiled().help("force per area at rest, of a fixed direction").unit("Pa");
    table.add("cauchyStress", given_stress_).help("xx xy yy zx yz zz of a stress that acts on the normals").unit("Pa");
    table.add("triangleList", list_).help("loaded triangles of the mesh").required();
    table.add("allowEmpty", allow_empty_).help("an empty list of triangles is not an error: nothing is loaded");
    table.add("useConstantForce", constant_).help("load by pressure and the area at rest, else by cauchyStress");
    table.add("useTangentStiffness", use_tangent_).help("false: the stress has no stiffness");
    table.addVisualOnly("showForces");
  }

  void init() override {
    ForceField::init();
    const char *needed = constant_ ? "pressure" : "cauchyStress", *other = constant_ ? "cauchyStress" : "pressure";
    if (data().find(other)->isSet())
      throw ComponentError(fmt::format("{} has no meaning with useConstantForce=\"{}\"", other, constant_),
                           fmt::format("{}, or useConstantForce=\"{}\"", needed, !constant_));
    if (!data().find(needed)->isSet())
      throw ComponentError(
          fmt::format("with useConstantForce=\"{}\" the load is {}, which is not given", constant_, needed),
          fmt::format("{}, or useConstantForce=\"{}\" and {}", needed, !constant_, other));
    setFaces(listedTriangles(surfaceMesh()));
    has_tangent = !constant_ && use_tangent_;
    if (constant_) {
      distribute();
      return;
    }
    if (given_stress_.size() != 6)
      throw ComponentError(fmt::format("cauchyStress has {} values", given_stress_.size()), "6: xx xy yy zx yz zz");
    const auto& s = given_stress_;
    stress_ << s[0], s[1], s[3], s[1], s[2], s[4], s[3], s[4], s[5];
  }

  ForceTraits traits() const override {
    ForceTraits traits = SurfaceLoad::traits();
    if (constant_) traits.linear = traits.constant_stiffness = traits.conservative = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < forces_.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) sum -= forces_[i].dot(x[rows_[i][a]]);
    return sum;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (!constant_) return SurfaceLoad::addForce(x, v, f);
    for (std::size_t i = 0; i < forces_.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) f[rows_[i][a]] += forces_[i];
  }

 protected:
  Mat3 stress(ConstRows) const override { return stress_; }
  bool hasPotential() const override { return false; }

 private:
  std::vector<Face> listedTriangles(const Mesh& mesh) const {
    if (list_.empty() && !allow_empty_)
      throw ComponentError("triangleList lists no triangle", "at least one",
                           "if a selection is linked here, check that its box contains triangles");
    if (list_.empty()) warn("triangleList lists no triangle: there is no load");
    std::vector<Face> faces;
    for (std::size_t i = 0; i < list_.size(); ++i) {
      if (list_[i] < 0 || std::size_t(list_[i]) >= mesh.triangles.size())
        throw ComponentError(
            fmt::format("triangleList[{}] is {}, and the mesh lists {} triangles", i, list_[i], mesh.triangles.size()),
            mesh.triangles.empty() ? "a mesh with triangles"
                                   : fmt::format("indices in 0 ... {}", mesh.triangles.size() - 1));
      faces.push_back(mesh.triangles[list_[i]]);
    }
    return faces;
  }
  /// The force on each corner of each triangle [N].
  void distribute() {
    forces_.clear();
    for (const Face& face : faces()) {
      const auto at = [&](std::size_t a) -> const Vec3& { return state().rest_position[face.nodes[a]]; };
      forces_.push_back((at(1) - at(0)).cross(at(2) - at(0)).norm() / 6 * pressure_);
    }
  }

  bool allow_empty_ = false;
  Vec3 pressure_ = Vec3::Zero();
  std::vector<double> given_stress_;
  std::vector<int> list_;
  bool constant_ = true, use_tangent_ = true;
  Mat3 stress_ = Mat3::Zero();
  std::vector<Vec3> forces_;  ///< shape (triangles)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(triangle_pressure_force_field) {
  factory.add<stroma::TrianglePressureForceField>("TrianglePressureForceField", "a dead load or a stress on triangles");
}
