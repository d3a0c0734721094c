// SPDX-License-Identifier: LGPL-2.1-or-later
// A form of a law at one integration point (hyperelastic_point.h) behind functions on packs, so that the loops of an
// element are compiled once for all laws. A call serves all lanes of a batch: beside the law's own work it is nothing.
#pragma once
#include <cstring>

#include "components/hyperelasticity/hyperelastic_point.h"
#include "components/hyperelasticity/hyperelastic_spectral.h"
#include "framework/fem/pack.h"

namespace stroma::hyperelastic {

/// Everything is scaled by `weight`, minus a volume [m^3], so that P g_i are forces.
struct PointFunctions {
  std::size_t parameters, tangent;  ///< how many packs each is
  bool anisotropic;                 ///< F is needed in the material's axes
  void (*read)(Values values, double* parameters);
  void (*stress)(const Pack* parameters, const Pack& weight, const M3<Pack>& f, Pack* tangent, M3<Pack>& p);
  /// dP at the F of the last stress().
  void (*differential)(const Pack* parameters, const Pack& weight, const Pack* tangent, const M3<Pack>& f,
                       const M3<Pack>& df, M3<Pack>& dp);
  void (*energy)(const Pack* parameters, const M3<Pack>& f, Pack& density);
};

template <class Form>
struct FunctionsOf {
  using Parameters = typename Form::template Parameters<Pack>;
  using Tangent = typename Form::template Tangent<Pack>;
  static const Parameters& parametersAt(const Pack* packs) { return *reinterpret_cast<const Parameters*>(packs); }

  static void read(Values values, double* out) {
    const auto parameters = parametersOf<typename Form::Law>(values);
    std::memcpy(out, &parameters, sizeof parameters);
  }
  [[gnu::flatten]] static void stress(const Pack* parameters, const Pack& weight, const M3<Pack>& f, Pack* tangent,
                                      M3<Pack>& p) {
    p = Form::stress(parametersAt(parameters), weight, f, *reinterpret_cast<Tangent*>(tangent));
  }
  [[gnu::flatten]] static void differential(const Pack* parameters, const Pack& weight, const Pack* tangent,
                                            const M3<Pack>& f, const M3<Pack>& df, M3<Pack>& dp) {
    dp = Form::differential(parametersAt(parameters), weight, *reinterpret_cast<const Tangent*>(tangent), f, df);
  }
  [[gnu::flatten]] static void energy(const Pack* parameters, const M3<Pack>& f, Pack& density) {
    density = Form::energy(parametersAt(parameters), f);
  }
  static constexpr PointFunctions all{sizeof(Parameters) / sizeof(Pack),
                                      sizeof(Tangent) / sizeof(Pack),
                                      Form::Law::Set::anisotropic,
                                      read,
                                      stress,
                                      differential,
                                      energy};
};

/// Null for the form regularised.
template <class Law>
const PointFunctions* pointFunctionsOf(Form form) {
  if (form == Form::mjed) return &FunctionsOf<Mjed<Law>>::all;
  if (form == Form::standard) return &FunctionsOf<Standard<Law>>::all;
  return form == Form::projected ? &FunctionsOf<Projected<Law>>::all : nullptr;
}

}  // namespace stroma::hyperelastic
