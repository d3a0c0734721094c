// SPDX-License-Identifier: LGPL-2.1-or-later
// BeamHookeLawForceField: the elasticity of a rod whose shape is given by strains, one node of a Vec3 or a Vec6 state for each section.
//
//   E = sum L_i/2 (k_i - k0_i)^T D (k_i - k0_i),   f_i = -L_i D (k_i - k0_i),   D = diag(G J, E Iy, E Iz),   G = E/(2 (1 + nu))
//   circular:     Iy = Iz = pi (r^4 - r_i^4)/4, J = Iy + Iz
//   rectangular:  Iy = ly lz^3/12, Iz = lz ly^3/12, J = Iy + Iz
//
// k [rad/m] are torsion and the two bendings, in the axes of the section, k0 those at rest. The force on a curvature is a moment
// [N m] times the length. With useInertiaParams D is diag(GI, EI, EI). With variantSections each section has its own modulus.
// DiscreteCosseratMapping makes frames of the curvatures.
//
// A node of a Vec6 state has the stretch and the two shears besides, with diag(E A, G A, G A), or diag(EA, GA, GA), and A the area of
// the section. The force on a stretch is a force [N] times the length. There is no factor of shear.
//
// Source: names, attributes, defaults and law are those of the plug-in Cosserat for SOFA; J of a rectangle is there the polar
// moment too, larger than its torsion constant.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="20" tolerance="1e-10"/>
//   <MechanicalObject name="curvature" position="1 0 1  0 1 2  0 0 0" rest_position="0 0 0  0 0 0  0 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <BeamHookeLawForceField length="0.1 0.1 0.2" radius="0.01" youngModulus="1e6" poissonRatio="0.4"/>
// </Node>
#include <fmt/format.h>

#include <numbers>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class BeamHookeLawForceField final : public NodeGroupField<1> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addChoice("crossSectionShape", shape_, {"circular", "rectangular"}).help("of the rod");
    table.add("youngModulus", young_).recompiled().help("Young's modulus").unit("Pa").min(0).physical();
    table.add("poissonRatio", poisson_).recompiled().help("Poisson's ratio").unit("-").min(-1, false).max(0.5);
    table.add("length", lengths_).recompiled().help("length of each section, or one for all").unit("m").min(0, false).required();
    table.add("radius", radius_).recompiled().help("of a circular section").unit("m").min(0, false);
    table.add("innerRadius", inner_).recompiled().help("of its bore").unit("m").min(0);
    table.add("lengthY", side_y_).help("side of a rectangular section along y").unit("m").min(0, false);
    table.add("lengthZ", side_z_).help("side of a rectangular section along z").unit("m").min(0, false);
    table.add("variantSections", varies_).help("each section has its own modulus and ratio");
    table.add("youngModulusList", young_of_).help("with variantSections, one for each").unit("Pa").min(0);
    table.add("poissonRatioList", poisson_of_)
        .help("with variantSections, one for each")
        .unit("-")
        .min(-1, false)
        .max(0.5);
    table.add("useInertiaParams", by_stiffness_).help("take GI and EI, not the moduli and the section");
    table.add("GI", torsion_).help("torsion stiffness").unit("N m^2").min(0);
    table.add("EI", bending_).help("bending stiffness").unit("N m^2").min(0);
    table.add("EA", stretching_).help("stretching stiffness, of rods that stretch").unit("N").min(0);
    table.add("GA", shearing_).help("shear stiffness, of rods that stretch").unit("N").min(0);
  }

  void init() override {
    ForceField::init();
    stretches_ = state().rows_per_node == 6 && state().kindOf(0) == RowKind::value;
    if (!stretches_ && !state().hasPointsOnly())
      throw ComponentError(state().path() + " has no strains of a rod", "a state of template Vec3 or Vec6, a node for each section");
    const auto sections = std::size_t(state().nodes());
    spread(lengths_, sections, "length", "sections");
    if (inner_ >= radius_)
      throw ComponentError(fmt::format("innerRadius is {} m, and radius {} m", inner_, radius_), "innerRadius < radius");
    if (by_stiffness_ && !(data().find("GI")->isSet() && data().find("EI")->isSet()))
      throw ComponentError("useInertiaParams is given without GI and EI", "GI=\"...\" EI=\"...\"");
    if (by_stiffness_ && stretches_ && !(data().find("GA")->isSet() && data().find("EA")->isSet()))
      throw ComponentError("useInertiaParams is given without GA and EA", "GA=\"...\" EA=\"...\"");
    warnOfSection();
    if (varies_ && by_stiffness_) throw ComponentError("variantSections and useInertiaParams are both given", "one of them");
    if (varies_) spread(young_of_, sections, "youngModulusList", "sections");
    if (varies_) spread(poisson_of_, sections, "poissonRatioList", "sections");
    constants_.clear();
    for (std::size_t i = 0; i < sections; ++i) {
      if (!stretches_) constants_.push_back(lengths_[i] * stiffnessOf(i));
      for (int k = 0; stretches_ && k < 6; ++k)
        constants_.push_back(lengths_[i] * (k < 3 ? stiffnessOf(i)[k] : stretchStiffnessOf(i)[k - 3]) * Vec3::UnitX());
    }
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (Index row = 0; row < state().size(); ++row) rows.push_back({state().firstRow() + row});
    setGroups(std::move(rows), false);
    for (std::size_t i = 0; i < constants_.size(); ++i) stiffness_[i].blocks[0] = (-constants_[i]).asDiagonal();
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < constants_.size(); ++i) sum += changeOf(i, x).dot(constants_[i].cwiseProduct(changeOf(i, x))) / 2;
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < constants_.size(); ++i) f[rows_[i][0]] -= constants_[i].cwiseProduct(changeOf(i, x));
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  void warnOfSection() const {
    const auto warnOf = [&](const char* name, double value) {
      if (!data().find(name)->isSet()) warn(fmt::format("{} is not given: the default {:g} m is used", name, value));
    };
    if (by_stiffness_) return;
    if (shape_ == Shape::circular) return warnOf("radius", radius_);
    warnOf("lengthY", side_y_), warnOf("lengthZ", side_z_);
  }
  Vec3 changeOf(std::size_t i, ConstRows x) const { return x[rows_[i][0]] - state().rest_position[i]; }
  /// The diagonal of D.
  Vec3 stiffnessOf(std::size_t i) const {
    if (by_stiffness_) return {torsion_, bending_, bending_};
    const double tube = std::numbers::pi * (radius_ * radius_ * radius_ * radius_ - inner_ * inner_ * inner_ * inner_) / 4;
    const double y = shape_ == Shape::circular ? tube : side_y_ * side_z_ * side_z_ * side_z_ / 12;
    const double z = shape_ == Shape::circular ? tube : side_z_ * side_y_ * side_y_ * side_y_ / 12;
    const double young = varies_ ? young_of_[i] : young_, poisson = varies_ ? poisson_of_[i] : poisson_;
    return {young / (2 * (1 + poisson)) * (y + z), young * y, young * z};
  }
  /// Of the stretch and both shears.
  Vec3 stretchStiffnessOf(std::size_t i) const {
    if (by_stiffness_) return {stretching_, shearing_, shearing_};
    const double area = shape_ == Shape::circular ? std::numbers::pi * (radius_ * radius_ - inner_ * inner_) : side_y_ * side_z_;
    const double young = varies_ ? young_of_[i] : young_, shear = young / (2 * (1 + (varies_ ? poisson_of_[i] : poisson_)));
    return {young * area, shear * area, shear * area};
  }

  enum class Shape : int { circular, rectangular } shape_ = Shape::circular;
  double young_ = 1e9, poisson_ = 0.45, radius_ = 1, inner_ = 0, side_y_ = 1, side_z_ = 1, torsion_ = 0, bending_ = 0, stretching_ = 0,
         shearing_ = 0;
  bool varies_ = false, by_stiffness_ = false, stretches_ = false;
  std::vector<double> lengths_, young_of_, poisson_of_;
  std::vector<Vec3> constants_;  ///< L D of each row
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(beam_hooke_law_force_field) {
  factory.add<stroma::BeamHookeLawForceField>("BeamHookeLawForceField", "the elasticity of a rod given by its strains");
}
