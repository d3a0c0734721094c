// SPDX-License-Identifier: LGPL-2.1-or-later
// HexahedronPorousForceField: the fluid in a tissue, added to any elastic hexahedra of a node. The stresses, Darcy's law,
// the couplings, the attributes and the sources are those of TetrahedronPorousForceField, whose page has the formulas.
//
// A cell has one J, the ratio of its current and rest volumes, and one pressure, the mean over the cell at rest of the
// trilinear P:
//
//   J = v/V,   P_e = sum_a V_a/V P_a,   V_a = int N_a dV,   f_a = -(sigma_H - alpha P_e) dv/dx_a
//   theta_a = sum_e alpha V_a ln J_e,   W_a = sum_e V_a,   L_ab = sum_e int grad N_a . grad N_b dV
//
// with v exact by 2x2x2 Gauss points, and L by the same. So undrained fluid or a small storage does not lock a cell, as a
// volume change at each point would, and a uniform pressure on cells of any shape is balanced exactly by uniform tractions.
// Bending a cell at constant volume moves no fluid: the elastic law has to resist it.
//
// Cell field for exporters: pressure (mean of a cell) [Pa]. The attribute pressure has it node by node.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="0.02 0.02 0.05"/>
//   <MechanicalObject/>
//   <DiagonalMass massDensity="1000"/>
//   <HexahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="2e3" poissonRatio="0.3"/>
//   <HexahedronPorousForceField fluidFraction="0.5" bulkModulus="400" limitModulus="2200" permeability="1e-6"
//                               biotCoefficient="0.9" biotModulus="2500" drainedIndices="@top.indices"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <BoxROI name="top" box="-1 -1 0.0499 1 1 1"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include <cmath>
#include <numeric>

#include "components/hyperelasticity/cell_volume.h"
#include "components/hyperelasticity/porous_force_field.h"
#include "components/hyperelasticity/porous_loops.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using hyperelastic::HexahedronVolume;
using porous::PorousCells;

struct PorousHexahedron {
  static constexpr int nodes = 8;
  template <class T>
  struct Rest {
    T scale;           ///< 1/512 over the mesh's overlap, with the sign of V; 0 for padding
    T per_volume;      ///< 1/(512 V), with the same sign [1/m^3]
    T inverse_volume;  ///< 1/V, V over the overlap [1/m^3]
    T share[8];        ///< V_a; 0 for padding [m^3]
  };
  template <class T>
  using Tangent = porous::Tangent<T>;

  template <class T>
  struct Shape {
    HexahedronVolume<T> volume;
    T scale, j;
    Shape(const Rest<T>& rest, const V3<T> (&x)[8])
        : volume(x), scale(rest.scale), j(rest.per_volume * volume.value()) {}
  };
  template <class T>
  static void forces(const Shape<T>& shape, T factor, V3<T> (&f)[8]) {
    shape.volume.gradient(shape.scale * factor, f);
  }
  template <class T>
  static T change(const Shape<T>& shape, const V3<T> (&dx)[8]) {
    return shape.scale * shape.volume.change(HexahedronVolume<T>(dx));
  }
  template <class T>
  static T mean(const Rest<T>& rest, const V3<T> (&of)[8]) {
    T sum(0.);
    for (int a = 0; a < 8; ++a) sum += rest.share[a] * of[a].x;
    return sum * rest.inverse_volume;
  }
  template <class T>
  static void share(const Rest<T>& rest, T density, V3<T> (&own)[8]) {
    for (int a = 0; a < 8; ++a) own[a].x = density * rest.share[a];
  }
  template <class T>
  static void split(const Rest<T>& rest, T whole, V3<T> (&own)[8]) {
    share(rest, whole * rest.inverse_volume, own);
  }

  /// df = -factor (stiffness dV dv/dx + stress d(dv/dx))
  template <class T>
  static void product(const Rest<T>& rest, T stiffness, T stress, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const HexahedronVolume<T> v(x), d(dx);
    const T minus = -factor * rest.scale;
    v.gradientChange(d, minus * stress, minus * stiffness * (rest.scale * v.change(d)), df);
  }
};

/// One hexahedron a lane.
struct PorousHexahedra {
  using Element = PorousHexahedron;
  static constexpr int nodes = Element::nodes, parts = 1;
  static constexpr int corner(int, int a) { return a; }
  template <class T>
  struct Rest {
    Element::Rest<T> of[1];
  };
  template <class T>
  struct Tangent {
    Element::Tangent<T> of[1];
  };
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[nodes],
                      const V3<T> (&dx)[nodes], V3<T> (&df)[nodes]) {
    Element::product(rest.of[0], t.of[0].stiffness, t.of[0].stress, factor, x, dx, df);
  }
  static void matrix(const Rest<Pack>& rest, const Tangent<Pack>& t, const V3<Pack> (&x)[nodes],
                     Pack (&k)[nodes * nodes * 9]) {
    ElementLoop<nodes>::matrixFromProducts(
        [&](const V3<Pack>(&dx)[nodes], V3<Pack>(&df)[nodes]) {
          Element::product(rest.of[0], t.of[0].assembled, t.of[0].stress, Pack(1.), x, dx, df);
        },
        k);
  }
};

class HexahedronPorousForceField final : public PorousForceField {
  const CellKind& kind() const override { return cell_kinds::hexahedron; }
  std::unique_ptr<porous::PorousElements> makeElements(const PorousCells& cells, const porous::Sponge& sponge,
                                                       Index first_row) const override;
};

std::unique_ptr<porous::PorousElements> HexahedronPorousForceField::makeElements(const PorousCells& cells,
                                                                                 const porous::Sponge& sponge,
                                                                                 Index first_row) const {
  const Mesh& mesh = cells.mesh();
  StorageOf<PorousHexahedra> storage;
  storage.build(mesh.hexahedra, cells.rest(), first_row, [&](std::size_t cell, bool padding, auto& data, auto&) {
    auto& rest = data.of[0];
    Vec3 corner[8];
    for (std::size_t a = 0; a < 8; ++a) corner[a] = cells.rest()[mesh.hexahedra[cell][a]];
    const double volume = cells.kind().size(corner);
    rest.scale = padding ? 0 : std::copysign(1 / (512 * mesh.overlap), volume);
    rest.per_volume = 1 / (512 * volume);
    rest.inverse_volume = mesh.overlap / std::abs(volume);
    const auto shares = cells.shares(cell);
    for (std::size_t a = 0; a < 8; ++a) rest.share[a] = padding ? 0 : shares[a];
  });
  return std::make_unique<porous::PorousLoops<PorousHexahedra>>(std::move(storage), sponge,
                                                                porous::PorousElements::Cost{60, 1200});
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(hexahedron_porous_force_field) {
  factory.add<stroma::HexahedronPorousForceField>(
      "HexahedronPorousForceField", "fluid in a tissue of hexahedra: effective volume, Darcy's law, pressure");
}
