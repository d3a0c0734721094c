// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear tetrahedra of a law in the forms standard and projected, compiled once for all laws: products read tangents that are the
// same for all, and the law's force is behind a function (point_functions.h) that has the loop in it.
#pragma once
#include "components/hyperelasticity/hyperelastic_tetrahedron.h"
#include "components/hyperelasticity/point_functions.h"

namespace stroma::hyperelastic {

/// A model of ProductLoops. `Form`: StandardTangent or ProjectedTangent.
template <class Form, class Frame_>
struct LawlessTetrahedron {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = true;
  using Frame = Frame_;
  template <class T>
  using Rest = FanCell<Frame, T>;
  template <class T>
  using Tangent = typename Form::template Tangent<T>;

  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const M3<T> f = Frame::deformation(tetrahedron::Edges(x).e, rest.g);
    const M3<T> change = Frame::deformation(tetrahedron::Edges(dx).e, rest.g) * factor;
    Frame::forces(Form::differential(t, f, change), rest.g, df);
  }
};

template <class Form, class Frame>
class FanLaw final : public ElementKernels {
  using Model = tetrahedron::FanOf<LawlessTetrahedron<Form, Frame>>;
  using Products = ProductLoops<Model>;
  using Corners = typename Model::template Corners<Pack>;

 public:
  FanLaw(const PointFunctions& law, const Cells& cells) : law_(law), cells_(cells) {
    using namespace tetrahedron;
    const std::vector<tetrahedron::Fan> fans = gatherFans(cells.mesh->tetrahedra, cells.rest->size());
    const auto nodes = nodesOf(fans);
    storage_.arrange(nodes, *cells.rest, cells.first_row);
    storage_.fill([&](std::size_t f, bool padding, auto& rest, auto&) {
      for (int i = 0; i < fan_size; ++i) {
        const Index e = fans[f].element[i];
        stroma::Tetrahedron order;
        for (int a = 0; a < 4; ++a) order[a] = nodes[f][corner(i, a)];
        const std::size_t cell = std::size_t(e >= 0 ? e : fans[f].element[0]);
        setTetrahedron<Frame>(cells, cell, order, law.anisotropic, padding || e < 0, rest.of[i].g, rest.of[i].weight);
      }
    });
    in_lanes_ = cellsInLanes(storage_.loop, fans);
    takeParameters();
  }
  bool refill() override {
    takeParameters();
    return true;
  }

  void addForce(ConstRows x, Rows f) override {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
    law_.fans(storage_.loop, parameters_.data(), storage_.rest.data(), storage_.tangent.data(), x, f);
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      Pack sum(0.), density;
      for (int i = 0; i < tetrahedron::fan_size; ++i) {
        const auto& rest = storage_.rest[b].of[i];
        law_.energy(parameters(b, i), deformation(in, rest, i), density);
        sum = sum + -rest.weight * density;
      }
      return sum;
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    Products::addProduct(storage_, x_, dx, factor, df);
  }
  void addPattern(BlockPattern& pattern) const override { storage_.loop.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return storage_.loop.slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    Products::assemble(storage_, x_, factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    Products::assembleDiagonal(storage_, x_, factor, blocks);
  }

 private:
  static M3<Pack> deformation(const V3<Pack> (&x)[tetrahedron::fan_nodes], const auto& rest, int i) {
    return Frame::deformation(tetrahedron::Edges(Corners(x, i).x).e, rest.g);
  }
  const Pack* parameters(Index b, int i) const {
    return parameters_.data() + (std::size_t(b) * tetrahedron::fan_size + std::size_t(i)) * law_.parameters;
  }
  void takeParameters() {
    std::vector<double> values(law_.parameters);
    parameters_.resize(std::size_t(storage_.loop.batches()) * tetrahedron::fan_size * law_.parameters);
    auto cell = in_lanes_.begin();
    for (Index b = 0; b < storage_.loop.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l)
        for (int i = 0; i < tetrahedron::fan_size; ++i) {
          law_.read(cells_.parameters(std::size_t(*cell++)), values.data());
          Pack* const packs = parameters_.data() + (parameters(b, i) - parameters_.data());
          for (std::size_t k = 0; k < values.size(); ++k) setLane(packs[k], l, values[k]);
        }
  }

  const PointFunctions& law_;
  const Cells cells_;
  std::vector<Index> in_lanes_;  ///< cellsInLanes()
  StorageOf<Model> storage_;
  Array<Pack> parameters_;  ///< shape (batches, tetrahedra of a fan, parameters of the law)
  Vector x_;                ///< of the last force
};

}  // namespace stroma::hyperelastic
