// SPDX-License-Identifier: LGPL-2.1-or-later
// The element loops of a sponge, for every kind of element: from J and its derivatives to forces, volumes and tangents.
#pragma once
#include "components/hyperelasticity/porous_elements.h"
#include "framework/fem/model_kernels.h"

namespace stroma::porous {

template <class T>
struct Tangent {
  T stress;     ///< sigma_H - alpha P [Pa]
  T stiffness;  ///< dsigma/dJ / V_0 [Pa/m^3], of the element alone, for products
  T assembled;  ///< the same for matrices
  T root;       ///< alpha (d ln J/dJ)^1/2
};

/// A group is what a lane of the loop holds, one element or several that share nodes: a model (model_kernels.h) whose
/// product and matrix are those of `stiffness` and `assembled`. It has
///   parts, corner(i, a)            how many elements; where node a of element i is among the nodes of the lane
///   Element                        its elements, with Rest<T>, where V_0 stands as inverse_volume, Shape<T> and
///     forces(shape, factor, f)     factor times the derivatives of V_0 J by the nodes
///     change(shape, dx)            the change of V_0 J
///     mean(rest, of)               of the nodes' numbers, in the x of each, over the element at rest
///     share(rest, density, own)    to the x of each node, density times its share of V_0
///     split(rest, whole, own)      the same shares of a number
/// where Shape(rest, x) has J as j. A padding lane has neither forces nor shares.
template <class Group>
class PorousLoops final : public PorousElements {
  using Storage = StorageOf<Group>;
  using Nodes = V3<Pack>[Group::nodes];
  using Matrix = Pack[Group::nodes * Group::nodes * 9];
  using Element = typename Group::Element;
  using Rest = typename Element::template Rest<Pack>;
  using Shape = typename Element::template Shape<Pack>;
  using Own = V3<Pack>[Element::nodes];

 public:
  PorousLoops(Storage&& storage, const Sponge& sponge, Cost cost)
      : storage_(std::move(storage)), sponge_(sponge), cost_(cost) {}
  void addPattern(BlockPattern& pattern) const override { storage_.loop.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return storage_.loop.slots(matrix); }

  void addForce(ConstRows x, ConstRows pressure, OwnFluid own_fluid, Rows f) override {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
    storage_.loop.template run<2, 1>({x, pressure}, {f}, [&](Index b, const auto& in, auto& out) {
      forEachElement(b, in[0], out[0], [&](int i, const Shape& shape, const Rest& rest, Own& own) {
        auto& t = storage_.tangent[b].of[i];
        t.stress = sponge_.stress(shape.j) - Pack(sponge_.coefficient) * mean(rest, in[1], i);
        const Pack slope = sponge_.logarithmSlope(shape.j), tissue = sponge_.slope(shape.j);
        const Pack both = tissue + Pack(sponge_.undrainedStiffening()) * slope;
        t.stiffness = (own_fluid.products ? both : tissue) * rest.inverse_volume;
        t.assembled = (own_fluid.matrices ? both : tissue) * rest.inverse_volume;
        t.root = Pack(sponge_.coefficient) * sqrt(slope);
        Element::forces(shape, -t.stress, own);
      });
    });
  }
  void addVolumes(ConstRows x, Rows theta) const override {
    storage_.loop.template run<1, 1>({x}, {theta}, [&](Index b, const auto& in, auto& out) {
      forEachElement(b, in[0], out[0], [&](int, const Shape& shape, const Rest& rest, Own& own) {
        Element::share(rest, Pack(sponge_.coefficient) * sponge_.logarithm(shape.j), own);
      });
    });
  }
  void addVolumeChanges(ConstRows dx, Rows theta) const override {
    storage_.loop.template run<2, 1>({x_.rows(), dx}, {theta}, [&](Index b, const auto& in, auto& out) {
      forEachElement(b, in[0], out[0], [&](int i, const Shape& shape, const Rest& rest, Own& own) {
        const Pack change = Element::change(shape, Corners(in[1], i).x);
        Element::split(rest, storage_.tangent[b].of[i].root * change, own);
      });
    });
  }
  void addPressureForces(ConstRows pressure, double factor, Rows f) const override {
    storage_.loop.template run<2, 1>({x_.rows(), pressure}, {f}, [&](Index b, const auto& in, auto& out) {
      forEachElement(b, in[0], out[0], [&](int i, const Shape& shape, const Rest& rest, Own& own) {
        Element::forces(shape, Pack(factor) * storage_.tangent[b].of[i].root * mean(rest, in[1], i), own);
      });
    });
  }
  double energy(ConstRows x, ConstRows pressure) const override {
    if (energies_.count() != x.count) energies_.resize(x.count);
    clear(energies_);
    storage_.loop.template run<2, 1>({x, pressure}, {energies_}, [&](Index b, const auto& in, auto& out) {
      forEachElement(b, in[0], out[0], [&](int i, const Shape& shape, const Rest& rest, Own& own) {
        const Pack pushed = Pack(sponge_.coefficient) * mean(rest, in[1], i);
        Element::share(rest, sponge_.energy(shape.j) - pushed * (shape.j - Pack(1.)), own);
      });
    });
    double sum = 0;
    for (Index i = 0; i < x.count; ++i) sum += energies_[i].x();
    return sum;
  }

  ConstRows positions() const override { return x_; }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.template run<2, 1>({x_.rows(), dx}, {df}, [&](Index b, const auto& in, auto& out) {
      Group::product(storage_.rest[b], storage_.tangent[b], scale, in[0], in[1], out[0]);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots.data(), values, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  Cost cost() const override { return cost_; }

 private:
  /// The nodes of element i of a lane.
  struct Corners {
    Own x;
    Corners(const Nodes& all, int i) {
#pragma GCC unroll 8  // else the packs go through memory
      for (int a = 0; a < Element::nodes; ++a) x[a] = all[Group::corner(i, a)];
    }
  };
  /// body(i, shape, rest, own) for the elements of batch b; own is added to the nodes' out.
  template <class Body>
  void forEachElement(Index b, const Nodes& x, Nodes& out, Body&& body) const {
    for (auto& node : out) node = {};
    for (int i = 0; i < Group::parts; ++i) {
      const Rest& rest = storage_.rest[b].of[i];
      Own own;
      body(i, Shape(rest, Corners(x, i).x), rest, own);
#pragma GCC unroll 8
      for (int a = 0; a < Element::nodes; ++a) out[Group::corner(i, a)] = out[Group::corner(i, a)] + own[a];
    }
  }
  static Pack mean(const Rest& rest, const Nodes& of, int i) { return Element::mean(rest, Corners(of, i).x); }
  /// noipa: as in model_kernels.h.
  [[gnu::noipa, gnu::flatten]] void matrix(Index b, Matrix& k) const {
    Nodes x;
    storage_.loop.gather(b, x_.rows(), x);
    Group::matrix(storage_.rest[b], storage_.tangent[b], x, k);
  }

  Storage storage_;
  Sponge sponge_;
  Cost cost_;
  Vector x_;                 ///< of the last force
  mutable Vector energies_;  ///< work space
};

}  // namespace stroma::porous
