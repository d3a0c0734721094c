// SPDX-License-Identifier: LGPL-2.1-or-later
// TriangularFEMForceField: an elastic membrane of linear triangles, in plane stress, that resists nothing but stretch
// and shear in the plane of each triangle.
//
//   W = A_0 h/2 sigma : eps,   eps = sym(R^T F) - I,   sigma = lambda tr(eps) I + 2 mu eps,   f = -dW/dx
//   lambda = E nu / (1 - nu^2), or E nu / ((1 + nu)(1 - 2 nu)) with planeStrain,   mu = E / (2 (1 + nu))
//
// F is the 3 x 2 deformation gradient, A_0 the area at rest, h the thickness, which does not change. method = large: R
// is the frame of the first edge and the plane of the triangle (QR). The force is the gradient of the energy, so that
// momentum and angular momentum are kept exactly; SOFA's force with the same frame differs from it in second order of
// the strain. method = small: R is the frame at rest, linear.
//
// tangent = warped holds R, with the stiffness across the plane that tension gives and without the one that compression
// takes: it is definite, so that long implicit steps of inflated and of buckling surfaces stay solvable. tangent =
// exact is the derivative of the force, for Newton's method; under compression it is not definite. Neither resists
// bending: TriangularBendingSprings or FastTriangularBendingSprings do.
//
// strain = rest and current are SOFA's forces, of the displacement u in the frame of the triangle: f = -R A0 h B^T D B u
// with the B of the rest shape or of the shape of the moment. They are no gradient, turn a free triangle a little, and
// differ from the others in second order of the strain. TriangularFEMForceFieldOptim has the first of them.
//
// initialPoints of TriangleFEMForceField are nodes of its rest shape, other than those of the state. restScale of
// TriangularFEMForceFieldOptim makes that shape larger: below 1 a sheet at the place of its state is stretched.
//
// TriangularAnisotropicFEMForceField is a sheet with fibres: sigma = T^T Q T eps, T turning to the fibre's axes, with
//
//   Q_11 = E/(1 - nu nu_t),  Q_12 = nu E_t/(1 - nu nu_t),  Q_22 = E_t/(1 - nu nu_t),  Q_66 = E/(2 (1 + nu)),  nu_t = nu E_t/E
//
// E along the fibres, E_t across them in the sheet. Fibres lie along (cos a, sin a, 0), a = fiberAngle, projected on each
// triangle at rest, or run about the point fiberCenter.
//
// Source: the name, method, moduli and drawing attributes are SOFA's; thickness (1 there), planeStrain of its
// TriangleFEMForceField, which is the same here, and tangent.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <TriangularFEMForceField youngModulus="1e4" poissonRatio="0.3" thickness="0.01" tangent="exact"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "components/elasticity/membrane.h"
#include "framework/fem/element_kernels_field.h"
#include "framework/fem/isotropic.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

using namespace stroma;

namespace {

class TriangularFEMForceField final : public ElementKernelsField {
 public:
  void declare(DataTable& table) override;
  void init() override;
  ForceTraits traits() const override {
    ForceTraits traits;
    const bool small = method_word_ == Method::small, own = strain == StrainWord::energy;
    traits.linear = traits.constant_stiffness = small;
    traits.symmetric = true;
    traits.forces_balance = !hasOtherShape();
    traits.has_rest_shape = true;
    traits.conservative = small || own;
    traits.exact_tangent = small || (own && tangent_ == TangentWord::exact);
    traits.torques_balance = !small && own;
    return traits;
  }
  void compile() override;
  /// Estimated from a tetrahedron's, for one core.
  Cost cost() const override {
    const double triangles = double(triangles_->size()), lanes = 8. / pack_lanes;
    return {(tangent_ == TangentWord::exact ? 12. : 4.) * lanes * triangles, 60 * triangles};
  }
  std::string worstElement(ConstRows x) const override;

  /// Set by the registration of a name.
  enum class StrainWord : int { energy, rest, current };
  StrainWord strain = StrainWord::energy;
  bool has_fibres = false, takes_points = false;

 private:
  enum class Method : int { small, large };
  enum class TangentWord : int { warped, exact };

  void checkTriangles() const;
  void declareFibres(DataTable& table);
  void checkFibres() const;
  Lame inPlane(std::size_t triangle) const;
  /// The axes of a triangle at rest: its first edge, and across it in the plane.
  std::array<Vec3, 2> axesOf(std::size_t triangle) const;
  Vec3 fibreOf(std::size_t triangle) const;
  Mat3 fibredStiffness(std::size_t triangle) const;
  membrane::Isotropic<double> lawOf(std::size_t triangle, double volume, membrane::Isotropic<double>) const;
  membrane::Fibred<double> lawOf(std::size_t triangle, double volume, membrane::Fibred<double>) const;
  template <template <class> class Law>
  std::unique_ptr<ElementKernels> makeMethod() const;
  template <class Position>
  Vec3 areaVector(std::size_t triangle, Position&& position) const {
    const Triangle& t = (*triangles_)[triangle];
    const Vec3 a = position(t[0]);
    return (position(t[1]) - a).cross(position(t[2]) - a) / 2;
  }
  bool hasOtherShape() const { return rest_scale_ != 1 || !initial_points_.empty(); }
  Vec3 restPosition(Index node) const {
    return rest_scale_ * (initial_points_.empty() ? state().rest_position : initial_points_)[std::size_t(node)];
  }
  std::string describe(std::size_t triangle) const {
    const Triangle& t = (*triangles_)[triangle];
    return fmt::format("triangle {} (nodes {} {} {})", triangle, t[0], t[1], t[2]);
  }

  void spreadValues(std::vector<double>& values, const char* attribute) const;

  TopologyLink topology_;
  std::vector<double> young_modulus_{5000}, poisson_ratio_{0.45}, transverse_modulus_{1000};
  double thickness_ = 1, fibre_angle_ = 0, rest_scale_ = 1;
  std::vector<Vec3> fibre_centre_, initial_points_;
  bool plane_strain_ = false, first_for_others_ = false;
  Method method_word_ = Method::large;
  TangentWord tangent_ = TangentWord::warped;
  const std::vector<Triangle>* triangles_ = nullptr;
  Index first_row_ = -1;  ///< that method_ was made for
};

void TriangularFEMForceField::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "mesh of triangles");
  table.add("youngModulus", young_modulus_)
      .recompiled()
      .help("Young's modulus: one value, or one per triangle")
      .unit("Pa")
      .min(0, false)
      .physical();
  table.add("poissonRatio", poisson_ratio_)
      .recompiled()
      .help("Poisson's ratio: one value, or one per triangle")
      .unit("-")
      .min(-1, false)
      .max(0.5)
      .physical();
  table.add("firstForOthers", first_for_others_)
      .help("triangles beyond the end of a list of youngModulus or poissonRatio take its first value, as in SOFA");
  table.add("thickness", thickness_).recompiled().help("thickness of the membrane").unit("m").min(0, false).physical();
  if (has_fibres)
    declareFibres(table);
  else
    table.add("planeStrain", plane_strain_).help("no strain across the plane, instead of no stress");
  table.addChoice("method", method_word_, {"small", "large"})
      .help("large: the strain in the frame of the triangle (QR); small: in its frame at rest, linear");
  table.addChoice("tangent", tangent_, {"warped", "exact"})
      .help("stiffness: R K R^T and that of tension, or the exact derivative of the force");
  table.addChoice("strain", strain, {"energy", "rest", "current"})
      .help("of large: energy, the gradient of an energy; rest and current, SOFA's, with its B of that shape");
  if (takes_points) table.add("initialPoints", initial_points_).help("nodes at rest; those of the state by default").unit("m");
  if (strain == StrainWord::rest) table.add("restScale", rest_scale_).help("of the size of the rest shape").unit("-").min(0, false);
  for (const char* name : {"hosfordExponant", "criteriaValue", "showStressValue", "showStressVector",
                           "showFracturableTriangles", "computePrincipalStress"})
    table.addVisualOnly(name);
}

void TriangularFEMForceField::declareFibres(DataTable& table) {
  table.add("transverseYoungModulus", transverse_modulus_)
      .recompiled()
      .help("Young's modulus across the fibres: one value, or one per triangle")
      .unit("Pa")
      .min(0, false)
      .physical();
  table.add("fiberAngle", fibre_angle_).help("angle between the fibres and the x axis, about z").unit("deg");
  table.add("fiberCenter", fibre_centre_).help("a point about which the fibres run instead").unit("m");
  table.addVisualOnly("showFiber");
}

void TriangularFEMForceField::init() {
  ForceField::init();
  const Mesh& mesh = topology_.meshWith(cell_kinds::triangle, *this, state());
  triangles_ = &mesh.triangles;
  const std::string problem = mesh.firstError();
  if (!problem.empty()) throw ComponentError(problem);
  if (strain != StrainWord::energy && (method_word_ == Method::small || tangent_ == TangentWord::exact))
    throw ComponentError("strain rest and current are of method large and the warped tangent", "strain=\"energy\"");
  if (!initial_points_.empty() && Index(initial_points_.size()) != state().nodes())
    throw ComponentError(fmt::format("initialPoints has {} points for {} nodes", initial_points_.size(), state().nodes()), "one each");
  if (hasOtherShape() && method_word_ == Method::small)
    throw ComponentError("initialPoints and restScale are of method large", "rest_position of the MechanicalObject");
  spreadValues(young_modulus_, "youngModulus"), spreadValues(poisson_ratio_, "poissonRatio");
  checkTriangles();
  if (has_fibres) {
    spreadValues(transverse_modulus_, "transverseYoungModulus");
    checkFibres();
  }
}

void TriangularFEMForceField::spreadValues(std::vector<double>& values, const char* attribute) const {
  const std::size_t given = values.size(), count = triangles_->size();
  if (first_for_others_ && given > 1 && given != count) {
    warn(fmt::format("{} has {} values for {} triangles: {}", attribute, given, count,
                     given < count ? "the others take the first" : "those beyond are left out"));
    values.resize(count, double(values.front()));
  }
  spread(values, count, attribute, "triangles");
}

void TriangularFEMForceField::checkTriangles() const {
  for (std::size_t i = 0; i < triangles_->size(); ++i) {
    const Triangle& t = (*triangles_)[i];
    double longest = 0;
    for (std::size_t a = 0; a < 3; ++a)
      longest = std::max(longest, (restPosition(t[(a + 1) % 3]) - restPosition(t[a])).squaredNorm());
    if (!(areaVector(i, [&](Index n) { return restPosition(n); }).norm() > 1e-9 * longest))
      throw ComponentError(describe(i) + " is a line at rest", "an area");
    if (plane_strain_ && poisson_ratio_[i] >= 0.5)
      throw ComponentError("poissonRatio is 0.5 with planeStrain", "a number below 0.5");
  }
}

Lame TriangularFEMForceField::inPlane(std::size_t triangle) const {
  const double e = young_modulus_[triangle], nu = poisson_ratio_[triangle];
  if (plane_strain_) return Lame::from(e, nu);
  return {e * nu / (1 - nu * nu), e / (2 * (1 + nu))};
}

void TriangularFEMForceField::checkFibres() const {
  if (fibre_centre_.size() > 1) throw ComponentError(fmt::format("fiberCenter has {} points", fibre_centre_.size()), "one point");
  for (std::size_t i = 0; i < triangles_->size(); ++i) {
    const double nu = poisson_ratio_[i], ratio = transverse_modulus_[i] / young_modulus_[i];
    if (!(nu * nu * ratio < 1))
      throw ComponentError(fmt::format("poissonRatio {:g} is too large where transverseYoungModulus is {:g} times youngModulus", nu,
                                       ratio),
                           fmt::format("below {:.3g}", 1 / std::sqrt(ratio)));
    const double length = fibre_centre_.empty() ? 1 : fibreOf(i).norm();
    const auto [axis0, axis1] = axesOf(i);
    const Vec3 fibre = fibreOf(i);
    if (!(std::hypot(fibre.dot(axis0), fibre.dot(axis1)) > 1e-9 * length))
      throw ComponentError("the fibres of " + describe(i) + " lie across it", "fibres in the sheet");
  }
}

std::array<Vec3, 2> TriangularFEMForceField::axesOf(std::size_t triangle) const {
  const Triangle& t = (*triangles_)[triangle];
  const Vec3 axis = (restPosition(t[1]) - restPosition(t[0])).normalized();
  return {axis, areaVector(triangle, [&](Index n) { return restPosition(n); }).normalized().cross(axis)};
}

Vec3 TriangularFEMForceField::fibreOf(std::size_t triangle) const {
  const double angle = fibre_angle_ * std::numbers::pi / 180;
  if (fibre_centre_.empty()) return {std::cos(angle), std::sin(angle), 0};
  const Triangle& t = (*triangles_)[triangle];
  const Vec3 middle = (restPosition(t[0]) + restPosition(t[1]) + restPosition(t[2])) / 3;
  return areaVector(triangle, [&](Index n) { return restPosition(n); }).normalized().cross(fibre_centre_[0] - middle);
}

/// T^T Q T of the top of the file [Pa], of the strains (eps_00, eps_11, 2 eps_01) in axesOf().
Mat3 TriangularFEMForceField::fibredStiffness(std::size_t triangle) const {
  const double along = young_modulus_[triangle], across = transverse_modulus_[triangle], nu = poisson_ratio_[triangle];
  const double part = 1 - nu * nu * across / along;
  Mat3 q = Mat3::Zero(), turn;
  q(0, 0) = along / part;
  q(1, 1) = across / part;
  q(0, 1) = q(1, 0) = nu * across / part;
  q(2, 2) = along / (2 * (1 + nu));
  const auto [axis0, axis1] = axesOf(triangle);
  const Vec3 fibre = fibreOf(triangle);
  const double x = fibre.dot(axis0), y = fibre.dot(axis1), length = std::hypot(x, y), c = x / length, s = y / length;
  turn << c * c, s * s, c * s, s * s, c * c, -c * s, -2 * c * s, 2 * c * s, c * c - s * s;
  return turn.transpose() * q * turn;
}

membrane::Isotropic<double> TriangularFEMForceField::lawOf(std::size_t triangle, double volume, membrane::Isotropic<double>) const {
  const Lame lame = inPlane(triangle);
  return {lame.lambda * volume, lame.mu * volume};
}

membrane::Fibred<double> TriangularFEMForceField::lawOf(std::size_t triangle, double volume, membrane::Fibred<double>) const {
  const Mat3 d = fibredStiffness(triangle) * volume;
  return {d(0, 0), d(0, 1), d(0, 2), d(1, 1), d(1, 2), d(2, 2)};
}

void TriangularFEMForceField::compile() {
  if (method_ && first_row_ == state().firstRow() && method_->refill()) return;
  first_row_ = state().firstRow();
  method_ = has_fibres ? makeMethod<membrane::Fibred>() : makeMethod<membrane::Isotropic>();
}

template <template <class> class Law>
std::unique_ptr<ElementKernels> TriangularFEMForceField::makeMethod() const {
  using Storage = membrane::Storage<Law>;
  using Tangent = membrane::TangentOf<double, Law<double>>;
  const auto fill = [this](Storage& stored) {
    stored.fill([this](std::size_t i, bool padding, membrane::Rest<double>& rest, Tangent& tangent) {
      const Triangle& t = (*triangles_)[i];
      const Vec3 e1 = restPosition(t[1]) - restPosition(t[0]), e2 = restPosition(t[2]) - restPosition(t[0]);
      const Vec3 axis0 = e1.normalized(), normal = e1.cross(e2), axis1 = normal.normalized().cross(axis0);
      const double x1 = e1.norm(), x2 = e2.dot(axis0), y2 = e2.dot(axis1);
      rest.inverse[0] = 1 / x1;
      rest.inverse[1] = -x2 / (x1 * y2);
      rest.inverse[2] = 1 / y2;
      tangent.axis0 = {axis0.x(), axis0.y(), axis0.z()};
      tangent.axis1 = {axis1.x(), axis1.y(), axis1.z()};
      for (int k = 0; k < 3; ++k) tangent.inverse[k] = rest.inverse[k];
      const double volume = padding ? 0 : normal.norm() / 2 * thickness_;  // a padding lane resists nothing
      tangent.law = lawOf(i, volume, Law<double>{});
    });
  };
  Storage storage;
  storage.arrange(*triangles_, state().rest_position, state().firstRow());
  fill(storage);
  const auto made = [&]<class Chosen>(std::type_identity<Chosen>) -> std::unique_ptr<ElementKernels> {
    return std::make_unique<ModelKernels<Chosen>>(std::move(storage), fill);
  };
  if (method_word_ == Method::small) return made(std::type_identity<membrane::Linear<Law>>());
  if (strain == StrainWord::rest) return made(std::type_identity<membrane::Displaced<Law, false>>());
  if (strain == StrainWord::current) return made(std::type_identity<membrane::Displaced<Law, true>>());
  if (tangent_ == TangentWord::exact) return made(std::type_identity<membrane::ExactLarge<Law>>());
  return made(std::type_identity<membrane::Large<Law>>());
}

std::string TriangularFEMForceField::worstElement(ConstRows x) const {
  double worst = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < triangles_->size() && worst == worst; ++i) {
    const double rest = areaVector(i, [&](Index n) { return restPosition(n); }).norm();
    const double now = areaVector(i, [&](Index n) -> Vec3 { return x[state().firstRow() + n]; }).norm();
    const double change = std::abs(std::log(now / rest));
    if (!(change <= worst)) worst = change, at = i;  // a NaN is the worst
  }
  const double rest = areaVector(at, [&](Index n) { return restPosition(n); }).norm();
  const double now = areaVector(at, [&](Index n) -> Vec3 { return x[state().firstRow() + n]; }).norm();
  return fmt::format("{}: {:.3g} times its area at rest", describe(at), now / rest);
}

}  // namespace

STROMA_COMPONENT(triangular_fem_force_field) {
  const std::string help = "an elastic membrane of triangles in plane stress";
  factory.add<TriangularFEMForceField>("TriangularFEMForceField", help);
  factory.add<TriangularFEMForceField>("TriangleFEMForceField", help, [](auto& f) { f.takes_points = true; });
  factory.add<TriangularFEMForceField>("TriangularFEMForceFieldOptim", help + ", with the strain of displacements", [](auto& f) {
    f.strain = TriangularFEMForceField::StrainWord::rest;
  });
  factory.add<TriangularFEMForceField>("TriangularAnisotropicFEMForceField", "an elastic membrane of triangles with fibres",
                                       [](auto& f) { f.has_fibres = true; });
}
