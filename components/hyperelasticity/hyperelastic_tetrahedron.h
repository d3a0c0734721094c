// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear tetrahedra of a hyperelastic law: one point, F = sum e_i (x) G_i, f_i = -V_0 P G_i. Isotropic laws see F up to
// a rotation of the rest shape: their gradients are stored in the frame in which G_1 is along x and G_2 in the xy
// plane, six numbers instead of nine.
#pragma once
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cstring>

#include "components/hyperelasticity/hyperelastic_law.h"
#include "components/hyperelasticity/hyperelastic_point.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/fan_model.h"

namespace stroma::hyperelastic {

/// Gradients (xx 0 0), (yx yy 0), (zx zy zz).
struct TriangularFrame {
  template <class T>
  struct Gradients {
    T xx, yx, yy, zx, zy, zz;
  };
  template <class T>
  static M3<T> deformation(const V3<T> (&e)[3], const Gradients<T>& g) {
    return {fma(g.xx, e[0], fma(g.yx, e[1], e[2] * g.zx)), fma(g.yy, e[1], e[2] * g.zy), e[2] * g.zz};
  }
  template <class T>
  static void forces(const M3<T>& p, const Gradients<T>& g, V3<T> (&f)[4]) {
    f[1] = p.c0 * g.xx;
    f[2] = fma(g.yx, p.c0, p.c1 * g.yy);
    f[3] = fma(g.zx, p.c0, fma(g.zy, p.c1, p.c2 * g.zz));
    f[0] = -(f[1] + f[2] + f[3]);
  }
  /// From columns G_i in any axes.
  static Gradients<double> of(const Mat3& g, const Mat3&) {
    const Vec3 x = g.col(0).normalized(), y = (g.col(1) - x * x.dot(g.col(1))).normalized(), z = x.cross(y);
    return {x.dot(g.col(0)), x.dot(g.col(1)), y.dot(g.col(1)), x.dot(g.col(2)), y.dot(g.col(2)), z.dot(g.col(2))};
  }
};

/// Gradients in the material's axes.
struct MaterialFrame {
  template <class T>
  using Gradients = elastic::Gradients<T>;
  template <class T>
  static M3<T> deformation(const V3<T> (&e)[3], const Gradients<T>& g) {
    return elastic::outerSum(e, g);
  }
  template <class T>
  static void forces(const M3<T>& p, const Gradients<T>& g, V3<T> (&f)[4]) {
    f[1] = p * g.g1, f[2] = p * g.g2, f[3] = p * g.g3;
    f[0] = -(f[1] + f[2] + f[3]);
  }
  static Gradients<double> of(const Mat3& g, const Mat3& axes) {
    const M3<double> own = fromEigen(axes.transpose() * g);
    return {own.c0, own.c1, own.c2};
  }
};

/// A tetrahedron of a fan whose law's numbers lie elsewhere (fan_law.h).
template <class Frame, class T>
struct FanCell {
  typename Frame::template Gradients<T> g;  ///< [1/m]
  T weight;                                 ///< -V_0 [m^3]
};
using FanLoop = ElementLoop<tetrahedron::fan_nodes, tetrahedron::FanCoupling>;

/// Gradients [1/m] and weight -V_0 [m^3] of a cell with its vertices in the order of `order`; a padding lane has no volume.
template <class Frame>
void setTetrahedron(const Cells& cells, std::size_t cell, const stroma::Tetrahedron& order, bool anisotropic,
                    bool padding, typename Frame::template Gradients<double>& g, double& weight) {
  const auto at = [&](int a) -> const Vec3& { return (*cells.rest)[order[a]]; };
  Mat3 edges;
  edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
  g = Frame::of(edges.inverse().transpose(), anisotropic ? cells.axes(cell) : Mat3(Mat3::Identity()));
  weight = padding ? 0 : -std::abs(edges.determinant()) / (6 * cells.mesh->overlap);
}

template <class Law>
using FrameOf = std::conditional_t<Law::Set::anisotropic, MaterialFrame, TriangularFrame>;

/// The same in all forms of a law.
template <class Law, class T>
struct TetrahedronRest {
  typename FrameOf<Law>::template Gradients<T> g;  ///< [1/m]
  T weight;                                        ///< -V_0 [m^3]
  ParametersOf<Law, T> parameters;
};

/// A model of ModelKernels, from a form of a law (Mjed, Standard, ...).
template <class Form>
struct Tetrahedron {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = true;
  using Frame = FrameOf<typename Form::Law>;
  template <class T>
  using Rest = TetrahedronRest<typename Form::Law, T>;
  template <class T>
  using Tangent = typename Form::template Tangent<T>;

  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    const M3<T> deformation = Frame::deformation(tetrahedron::Edges(x).e, rest.g);
    Frame::forces(Form::stress(rest.parameters, rest.weight, deformation, t), rest.g, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>&, const V3<T> (&x)[4]) {
    return -rest.weight * Form::energy(rest.parameters, Frame::deformation(tetrahedron::Edges(x).e, rest.g));
  }
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const M3<T> f = Frame::deformation(tetrahedron::Edges(x).e, rest.g);
    const M3<T> change = Frame::deformation(tetrahedron::Edges(dx).e, rest.g) * factor;
    Frame::forces(Form::differential(rest.parameters, rest.weight, t, f, change), rest.g, df);
  }

  static void set(const Cells& cells, std::size_t cell, const stroma::Tetrahedron& order, bool padding,
                  Rest<double>& rest) {
    setTetrahedron<Frame>(cells, cell, order, Form::Law::Set::anisotropic, padding, rest.g, rest.weight);
    rest.parameters = parametersOf<typename Form::Law>(cells.parameters(cell));
  }
};

template <class Form>
using Fan = tetrahedron::FanOf<Tetrahedron<Form>>;
/// On the same data as Mjed, with its forces and energy.
template <class Law>
struct RegularisedFan : Fan<Regularised<Law>> {
  using Forces = Fan<Mjed<Law>>;
};

/// The cell of each tetrahedron, shape (batches, lanes, fan_size). Padding, and the second place of a single cell, repeat another.
inline std::vector<Index> cellsInLanes(const FanLoop& loop, const std::vector<tetrahedron::Fan>& fans) {
  std::vector<Index> cells;
  cells.reserve(std::size_t(loop.batches()) * pack_lanes * tetrahedron::fan_size);
  for (Index b = 0; b < loop.batches(); ++b)
    for (int l = 0; l < pack_lanes; ++l) {
      const Index f = loop.elementOf(b, l);
      const tetrahedron::Fan& fan = fans[std::size_t(f >= 0 ? f : loop.elementOf(b, 0))];
      for (const Index e : fan.element) cells.push_back(e >= 0 ? e : fan.element[0]);
    }
  return cells;
}

/// Fans of a law with the kernels of Model, whose data are those of Fan<Mjed<Law>>.
template <class Law, class Model>
std::unique_ptr<ElementKernels> fansOf(const Cells& cells) {
  using namespace tetrahedron;
  using Storage = StorageOf<hyperelastic::Fan<Mjed<Law>>>;
  const std::vector<tetrahedron::Fan> fans = gatherFans(cells.mesh->tetrahedra, cells.rest->size());
  const auto nodes = nodesOf(fans);
  Storage storage;
  storage.build(nodes, *cells.rest, cells.first_row, [&](std::size_t f, bool padding, auto& rest, auto&) {
    for (int i = 0; i < fan_size; ++i) {
      const Index e = fans[f].element[i];
      stroma::Tetrahedron order;
      for (int a = 0; a < 4; ++a) order[a] = nodes[f][corner(i, a)];
      hyperelastic::Tetrahedron<Mjed<Law>>::set(cells, std::size_t(e >= 0 ? e : fans[f].element[0]), order,
                                                padding || e < 0, rest.of[i]);
    }
  });
  auto refill = [cells, in_lanes = cellsInLanes(storage.loop, fans)](Storage& stored) {
    auto cell = in_lanes.begin();
    for (auto& batch : stored.rest)
      for (int l = 0; l < pack_lanes; ++l)
        for (auto& of : batch.of) setLane(of.parameters, l, parametersOf<Law>(cells.parameters(std::size_t(*cell++))));
  };
  return std::make_unique<ModelKernels<Model>>(std::move(storage), std::move(refill));
}
}  // namespace stroma::hyperelastic
