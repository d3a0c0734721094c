// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/hexahedron_work.h"

#include <random>

#include "components/elasticity/hexahedron_shapes.h"
#include "tools/bench/counted.h"

namespace stroma::bench {
namespace {

using namespace stroma::hexahedron;

/// Cubes as the benchmarks deform them; what the numbers are matters to the iterations of a rotation alone.
template <class Model>
struct Sample {
  typename Model::template Rest<Counted> rest{};
  typename Model::template Tangent<Counted> tangent{};
  V3<Counted> x[8], f[8];

  explicit Sample(std::mt19937& random) {
    std::uniform_real_distribution<double> noise(-0.1, 0.1), angle(-2, 2);
    const double a = angle(random), c = std::cos(a), s = std::sin(a);
    for (int i = 0; i < 8; ++i) {
      const double p[3] = {((i ^ i >> 1) & 1) + noise(random), (i >> 1 & 1) + noise(random), (i >> 2) + noise(random)};
      x[i] = {Counted(c * p[0] - s * p[1]), Counted(s * p[0] + c * p[1]), Counted(p[2])};
    }
    const Counted one(1), zero(0);
    const Gradients<Counted> g{{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
    if constexpr (requires { tangent.stiffness; })
      for (int i = 0; i < 3; ++i) rest.edges[i] = Counted(4), tangent.stiffness.inverse[i] = Counted(2);
    if constexpr (requires { tangent.gradient; })
      for (int i = 0; i < 3; ++i) tangent.gradient[i] = tangent.inverse_weight = one;
    if constexpr (requires { rest.inverse_edges; }) {
      const double quarter[6] = {0.25, 0, 0.25, 0, 0, 0.25};
      for (int i = 0; i < 6; ++i) rest.inverse_edges[i] = Counted(quarter[i]);
      for (int p = 0; p < 8; ++p) rest.g[p] = g, rest.scale[p] = rest.inverse_determinant[p] = one;
    }
  }
};

constexpr double scatter_flops = 24;  // eight nodes, three components

template <class Model, class Kernel>
double meanFlops(Kernel&& kernel) {
  constexpr int count = 200;
  std::mt19937 random(1);
  long flops = 0;
  for (int i = 0; i < count; ++i) {
    Sample<Model> sample(random);
    Counted::flops = 0;
    kernel(sample);
    flops += Counted::flops;
  }
  return scatter_flops + double(flops) / count;
}

/// call.operator()<Model>() for the model of a variant.
template <class Call>
Work forModel(HexahedronVariant variant, Call&& call) {
  using rotation::Polar;
  switch (variant) {
    case HexahedronVariant::polar_boxes:
      return call.template operator()<BoxCorotational<Polar>>();
    case HexahedronVariant::polar_b:
      return call.template operator()<PointCorotational<LocalDilatation, Polar, Update::strain_displacement>>();
    default:
      return call.template operator()<Green<BoxShape, false>>();
  }
}

constexpr double node_numbers = 8 * 4, vector_row = 4 * sizeof(double);

}  // namespace

Work hexahedronProductWork(HexahedronVariant variant, double nodes) {
  return forModel(variant, [&]<class Model>() -> Work {
    const double flops =
        meanFlops<Model>([](auto& s) { Model::product(s.rest, s.tangent, Counted(1), s.x, s.x, s.f); });
    double bytes = node_numbers + sizeof(typename Model::template Tangent<double>) + 3 * vector_row * nodes;
    if (Model::reads_position) bytes += sizeof(typename Model::template Rest<double>) + vector_row * nodes;
    return {bytes, flops};
  });
}

Work hexahedronForceWork(HexahedronVariant variant, double nodes) {
  return forModel(variant, [&]<class Model>() -> Work {
    const double flops = meanFlops<Model>([](auto& s) { Model::force(s.rest, s.tangent, s.x, s.f); });
    return {node_numbers + sizeof(typename Model::template Rest<double>) +
                sizeof(typename Model::template Tangent<double>) + 3 * vector_row * nodes,
            flops};
  });
}

}  // namespace stroma::bench
