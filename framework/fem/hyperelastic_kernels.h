// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of a law, from its energy. A law is a struct with
//   Set                      the invariants it depends on (hyperelastic_invariants.h): First, FirstAndSecond, ...
//   anisotropic              whether it reads the material's axes
//   Parameters<T>            a struct of T, in the order of ParameterSet
//   energy(J, I..., p)       the energy density, a template: numbers give the energy, jets its derivatives too
// It belongs into one .cpp, which includes this header and nothing else does: kernels are large.
#pragma once
#include "framework/fem/hyperelastic_spectral.h"
#include "framework/fem/hyperelastic_tetrahedron.h"

namespace stroma::hyperelastic {

template <class Law>
std::unique_ptr<ElementMethod> tetrahedraOf(const Cells& cells) {
  const auto make = [&]<class Point>() -> std::unique_ptr<ElementMethod> {
    return std::make_unique<ModelMethod<Fan<Point>>>(fansOf<Point>(cells));
  };
  switch (cells.form) {
    case Form::regularised:
      return make.template operator()<Regularised<Law>>();
    case Form::projected:
      return make.template operator()<Projected<Law>>();
    case Form::standard:
      return make.template operator()<Standard<Law>>();
    default:
      return make.template operator()<Mjed<Law>>();
  }
}

template <class Law>
typename Law::template Parameters<double> parametersOf(const double* values) {
  typename Law::template Parameters<double> parameters;
  std::memcpy(&parameters, values, sizeof parameters);
  return parameters;
}

/// Fills in the kernels; name, parameters and the rest are the law's own.
template <class Law>
HyperelasticLaw lawOf(HyperelasticLaw law) {
  law.tetrahedra = tetrahedraOf<Law>;
  law.stress = [](const double* values, const Mat3& f) -> Mat3 {
    typename Mjed<Law>::template Tangent<double> t;
    return toEigen(Mjed<Law>::stress(parametersOf<Law>(values), 1., fromEigen(f), t));
  };
  law.energy = [](const double* values, const Mat3& f) {
    return Mjed<Law>::energy(parametersOf<Law>(values), fromEigen(f));
  };
  return law;
}

}  // namespace stroma::hyperelastic
