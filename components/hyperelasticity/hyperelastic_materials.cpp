// SPDX-License-Identifier: LGPL-2.1-or-later
// Materials as components, for HyperelasticityFEMForceField. They are laws of TetrahedronHyperelasticityFEMForceField, whose page
// says what is computed, with parameters of other names. C = F^T F, J = det F, S = 2 dW/dC the second Piola-Kirchhoff stress:
//   NeoHookeanMaterial       youngModulus poissonRatio: NeoHookean
//                            S = mu (Id - C^-1) + lambda ln J C^-1
//   StVenantKirchhoffMaterial  youngModulus poissonRatio: StVenantKirchhoff
//                            S = lambda tr(E) Id + 2 mu E, E = (C - Id)/2
//   MooneyRivlinMaterial     mu10 mu01 bulkModulus: MooneyRivlin, c1 = mu10, c2 = mu01, k0 = bulkModulus
//                            S = 2 mu10 J^-2/3 (Id - I1/3 C^-1) + 2 mu01 J^-4/3 (I1 Id - C - 2/3 I2 C^-1) + bulkModulus ln J C^-1
//   OgdenMaterial            mu alpha kappa: Ogden of one term, mu1 = mu, alpha1 = alpha, k0 = kappa
//                            S = mu/alpha J^-alpha/3 (C^(alpha/2 - 1) - tr(C^(alpha/2))/3 C^-1) + kappa ln J C^-1
//   IncompressibleMooneyRivlinMaterial  mu10 mu01
//                            S = 2 mu10 Id + 2 mu01 (I1 Id - C), the derivative of mu10 (I1 - 3) + mu01 (I2 - 3)
// with Lame's constants lambda = E nu/((1 + nu)(1 - 2 nu)) and mu = E/(2 (1 + nu)). At small strains the shear modulus is
// 2 (mu10 + mu01), or mu/2 of OgdenMaterial. These are SOFA's names, defaults and formulas.
//
// IncompressibleMooneyRivlinMaterial is what remains of the law where something else holds the volume. Nothing in the field does:
// its stress at rest is (2 mu10 + 4 mu01) Id, which draws a body together. Without VolumeConstraint, or a pressure, or nodes
// that are held all around, it shrinks to a point; MooneyRivlinMaterial with a large bulkModulus is what resists.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.04"/>
//   <MooneyRivlinMaterial mu10="2000" mu01="1500" bulkModulus="3e4"/>
//   <HyperelasticityFEMForceField template="Vec3,Hexahedron"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/hyperelasticity/hyperelastic_kernels.h"
#include "components/hyperelasticity/hyperelastic_material.h"

namespace stroma {
namespace {

using hyperelastic::HyperelasticLaw;

/// The law that is offered under a name, of one term.
HyperelasticLaw offered(const std::string& name) {
  const auto& laws = hyperelastic::hyperelasticLaws();
  const auto found = std::find_if(laws.begin(), laws.end(), [&](const HyperelasticLaw& law) { return law.name == name; });
  return found->with_terms ? found->with_terms(1) : *found;
}

/// Without a part for the volume, and with a stress at rest: no law for materialName.
struct IncompressibleMooneyRivlin {
  using Set = hyperelastic::FirstAndSecond;
  template <class T>
  struct Parameters {
    T mu10, mu01;
  };
  static auto energy(const auto&, const auto& I1, const auto& I2, const auto& p) {
    return p.mu10 * (I1 - 3.) + p.mu01 * (I2 - 3.);
  }
};

/// An attribute: one number.
struct Parameter {
  const char *name, *unit, *help;
  double value;
  bool is_positive = false;
};

class Material : public HyperelasticMaterial {
 public:
  std::string law_name;
  std::vector<Parameter> numbers;

  void declare(DataTable& table) override {
    table.add("template", template_).help("Vec3");
    for (Parameter& number : numbers) {
      Data& data = table.add(number.name, number.value).recompiled().unit(number.unit).physical().help(number.help);
      if (number.is_positive) data.min(0, false);
    }
  }
  void init() override {
    if (!template_.empty() && template_.rfind("Vec3", 0) != 0)
      throw ComponentError(fmt::format("template '{}' is none that {} has", template_, type()), "Vec3");
  }
  HyperelasticLaw law() const override {
    HyperelasticLaw law = offered(law_name);
    for (std::size_t i = 0; i < numbers.size(); ++i) law.parameters[i].name = numbers[i].name;
    return law;
  }
  std::vector<double> values() const override {
    std::vector<double> values;
    for (const Parameter& number : numbers) values.push_back(number.value);
    return values;
  }

 private:
  std::string template_;
};

class HookesMaterial final : public Material {
 public:
  void declare(DataTable& table) override {
    numbers = {{"youngModulus", "Pa", "Young's modulus at small strains", 1e6, true},
               {"poissonRatio", "-", "Poisson's ratio at small strains", 0.45}};
    Material::declare(table);
    table.find("poissonRatio")->min(-1, false).max(0.5, false);
  }
  HyperelasticLaw law() const override { return offered(law_name); }
  std::vector<double> values() const override {
    const Lame lame = Lame::from(numbers[0].value, numbers[1].value);
    return {lame.mu, lame.lambda};
  }
};

const std::vector<Parameter> mooney_rivlin{{"mu10", "Pa", "factor of the first invariant", 1e3},
                                           {"mu01", "Pa", "factor of the second invariant", 1e3}};

class MooneyRivlinMaterial final : public Material {
 public:
  void declare(DataTable& table) override {
    law_name = "MooneyRivlin", numbers = mooney_rivlin;
    numbers.push_back({"bulkModulus", "Pa", "bulk modulus, factor of (ln J)^2/2", 1e2, true});
    Material::declare(table);
  }
  void init() override {
    Material::init();
    if (!(numbers[0].value + numbers[1].value > 0))
      throw ComponentError("mu10 + mu01 is not above 0: the shear modulus is twice that", "mu10 + mu01 above 0");
  }
};

class OgdenMaterial final : public Material {
 public:
  void declare(DataTable& table) override {
    law_name = "Ogden";
    numbers = {{"mu", "Pa", "twice the shear modulus at small strains", 1e2, true},
               {"alpha", "-", "exponent of the principal stretches", 1.5},
               {"kappa", "Pa", "bulk modulus, factor of (ln J)^2/2", 1e3, true}};
    Material::declare(table);
  }
  void init() override {
    Material::init();
    if (numbers[1].value == 0) throw ComponentError("alpha is 0", "an exponent other than 0");
  }
};

class IncompressibleMooneyRivlinMaterial final : public Material {
 public:
  void declare(DataTable& table) override {
    numbers = mooney_rivlin;
    Material::declare(table);
  }
  void init() override {
    Material::init();
    if (!(numbers[0].value + numbers[1].value > 0))
      throw ComponentError("mu10 + mu01 is not above 0: the shear modulus is twice that", "mu10 + mu01 above 0");
    warn(fmt::format("this law does not resist changes of volume, and a body at rest has a tension of {:g} Pa: an unsupported body "
                     "shrinks to a point",
                     2 * numbers[0].value + 4 * numbers[1].value),
         "MooneyRivlinMaterial with a large bulkModulus");
  }
  HyperelasticLaw law() const override {
    return hyperelastic::lawOf<IncompressibleMooneyRivlin>("IncompressibleMooneyRivlin", "mu10 (I1 - 3) + mu01 (I2 - 3)",
                                                           {{"mu10", "Pa", ""}, {"mu01", "Pa", ""}});
  }
};

}  // namespace
}  // namespace stroma

using namespace stroma;

STROMA_COMPONENT(hyperelastic_materials) {
  const std::string help = "material of HyperelasticityFEMForceField: ";
  factory.add<HookesMaterial>("NeoHookeanMaterial", help + "neo-Hooke", [](HookesMaterial& m) { m.law_name = "NeoHookean"; });
  factory.add<HookesMaterial>("StVenantKirchhoffMaterial", help + "St. Venant-Kirchhoff",
                              [](HookesMaterial& m) { m.law_name = "StVenantKirchhoff"; });
  factory.add<MooneyRivlinMaterial>("MooneyRivlinMaterial", help + "Mooney-Rivlin");
  factory.add<OgdenMaterial>("OgdenMaterial", help + "Ogden, one term");
  factory.add<IncompressibleMooneyRivlinMaterial>("IncompressibleMooneyRivlinMaterial",
                                                  help + "Mooney-Rivlin without a part for the volume");
}
