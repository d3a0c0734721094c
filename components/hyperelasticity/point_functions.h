// SPDX-License-Identifier: LGPL-2.1-or-later
// A form of a law at one integration point (hyperelastic_point.h) behind functions on packs, so that the loops of an
// element are compiled once for all laws. A call serves all lanes of a batch: beside the law's own work it is nothing.
#pragma once
#include <cstring>

#include "components/hyperelasticity/hyperelastic_point.h"
#include "components/hyperelasticity/hyperelastic_spectral.h"
#include "components/hyperelasticity/hyperelastic_tetrahedron.h"
#include "framework/fem/pack.h"

namespace stroma::hyperelastic {

/// Everything is scaled by `weight`, minus a volume [m^3], so that P g_i are forces. What nobody calls in a form is null: in
/// standard all but read(), energy() and fans(), in mjed fans().
struct PointFunctions {
  std::size_t parameters, tangent;  ///< how many packs each is
  bool anisotropic;                 ///< F is needed in the material's axes
  void (*read)(Values values, double* parameters);
  void (*stress)(const Pack* parameters, const Pack& weight, const M3<Pack>& f, Pack* tangent, M3<Pack>& p);
  /// dP at the F of the last stress().
  void (*differential)(const Pack* parameters, const Pack& weight, const Pack* tangent, const M3<Pack>& f,
                       const M3<Pack>& df, M3<Pack>& dp);
  void (*energy)(const Pack* parameters, const M3<Pack>& f, Pack& density);
  /// The forces of all fans (fan_law.h), in a loop of its own: a law has little to do at one point. `rest`, `tangent`:
  /// Fanned<FanCell> and Fanned<Tangent>, shape (batches).
  void (*fans)(const FanLoop& loop, const Pack* parameters, const void* rest, void* tangent, ConstRows x, Rows f);
};

template <class Form>
struct FunctionsOf {
  using Parameters = typename Form::template Parameters<Pack>;
  using Tangent = typename Form::template Tangent<Pack>;
  static constexpr std::size_t tangent_packs = sizeof(Tangent) / sizeof(Pack);
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
  static void fans(const FanLoop& loop, const Pack* parameters, const void* rest, void* tangent, ConstRows x, Rows f) {
    using Frame = FrameOf<typename Form::Law>;
    using Fans = Fan<Form>;
    const auto* const all_numbers = reinterpret_cast<const tetrahedron::Fanned<Parameters>*>(parameters);
    const auto* const all_rests = static_cast<const tetrahedron::Fanned<FanCell<Frame, Pack>>*>(rest);
    auto* const all_tangents = static_cast<tetrahedron::Fanned<Tangent>*>(tangent);
    loop.template run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) {
      Fans::gatherForces(out[0], [&](int i, V3<Pack>(&own)[4]) {
        const typename Fans::template Corners<Pack> corners(in[0], i);
        const FanCell<Frame, Pack>& cell = all_rests[b].of[i];
        const M3<Pack> deformation = Frame::deformation(tetrahedron::Edges(corners.x).e, cell.g);
        Frame::forces(Form::stress(all_numbers[b].of[i], cell.weight, deformation, all_tangents[b].of[i]), cell.g, own);
      });
    });
  }
};

/// Null for the form regularised.
template <class Law>
const PointFunctions* pointFunctionsOf(Form form) {
  using Exact = FunctionsOf<Mjed<Law>>;
  using Stable = FunctionsOf<Projected<Law>>;
  using Textbook = FunctionsOf<Standard<Law>>;
  constexpr std::size_t parameters = sizeof(typename Exact::Parameters) / sizeof(Pack);
  constexpr bool anisotropic = Law::Set::anisotropic;
  static constexpr PointFunctions mjed{parameters,    Exact::tangent_packs, anisotropic,   Exact::read,
                                       Exact::stress, Exact::differential,  Exact::energy, nullptr};
  static constexpr PointFunctions projected{parameters,     Stable::tangent_packs, anisotropic,   Exact::read,
                                            Stable::stress, Stable::differential,  Exact::energy, Stable::fans};
  static constexpr PointFunctions standard{parameters, Textbook::tangent_packs, anisotropic,   Exact::read, nullptr,
                                           nullptr,    Exact::energy,           Textbook::fans};
  if (form == Form::mjed) return &mjed;
  if (form == Form::standard) return &standard;
  return form == Form::projected ? &projected : nullptr;
}

}  // namespace stroma::hyperelastic
