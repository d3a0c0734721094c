// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of a law, from its energy. A law is a struct with
//   Set                      the invariants it depends on (hyperelastic_invariants.h): First, FirstAndSecond, ...
//   Parameters<T>            a struct of T, in the order of ParameterSet; or in its own, with read(values)
//   energy(J, I..., p)       the energy density, a template: numbers give the energy, jets its derivatives too
// It belongs into one .cpp, which includes this header and nothing else does: kernels are large.
#pragma once
#include "components/hyperelasticity/hyperelastic_spectral.h"
#include "components/hyperelasticity/hyperelastic_tetrahedron.h"
#include "components/hyperelasticity/point_functions.h"
#include "framework/scene/factory.h"

namespace stroma::hyperelastic {

/// The kernels of the forms mjed and regularised, whose products are the law's own.
template <class Law>
std::unique_ptr<ElementKernels> tetrahedraOf(const Cells& cells) {
  if (cells.form == Form::regularised) return fansOf<Law, RegularisedFan<Law>>(cells);
  return fansOf<Law, Fan<Mjed<Law>>>(cells);
}

/// A law that has Lame's constants alone; inLameConstants() describes them.
template <class Set_>
struct InLameConstants {
  using Set = Set_;
  template <class T>
  struct Parameters {
    T mu, lambda;
  };
};

/// The energy Law::isochoric(J^-2/3 I1, p) + k0/2 (ln J)^2, or with J^-4/3 I2 after I1; withBulkModulus() describes k0.
template <class Law, class Set_>
struct IsochoricAndBulk {
  using Set = Set_;
  static auto energy(const auto& J, const auto& I1, const auto& p) {
    const auto L = log(J);
    return Law::isochoric(exp((-2. / 3) * L) * I1, p) + 0.5 * p.k0 * (L * L);
  }
  static auto energy(const auto& J, const auto& I1, const auto& I2, const auto& p) {
    const auto L = log(J);
    const auto scale = exp((-2. / 3) * L);
    return Law::isochoric(scale * I1, scale * scale * I2, p) + 0.5 * p.k0 * (L * L);
  }
};

/// A law with its kernels: what it is called, its energy for the manual, its parameters. The rest is the law's own.
template <class Law>
HyperelasticLaw lawOf(std::string name, std::string formula, std::vector<ParameterInfo> parameters = {}) {
  HyperelasticLaw law;
  law.name = std::move(name), law.formula = std::move(formula), law.parameters = std::move(parameters);
  law.tetrahedra = tetrahedraOf<Law>;
  law.at_point = pointFunctionsOf<Law>;
  law.stress = [](Values values, const Mat3& f) -> Mat3 {
    typename Mjed<Law>::template Tangent<double> t;
    return toEigen(Mjed<Law>::stress(parametersOf<Law>(values), 1., fromEigen(f), t));
  };
  law.differential = [](Values values, const Mat3& f, const Mat3& df) -> Mat3 {
    const auto numbers = parametersOf<Law>(values);
    typename Mjed<Law>::template Tangent<double> t;
    Mjed<Law>::stress(numbers, 1., fromEigen(f), t);
    return toEigen(Mjed<Law>::differential(numbers, 1., t, fromEigen(f), fromEigen(df)));
  };
  if constexpr (!InPrincipalStretches<Law>) law.curved_in_volume = NotZero<decltype(Derivatives<Law, double>::aa)>;
  return law;
}

}  // namespace stroma::hyperelastic
