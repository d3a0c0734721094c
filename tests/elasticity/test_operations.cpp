// SPDX-License-Identifier: LGPL-2.1-or-later
// The operations of the element kernels, counted: what `stroma bench` takes them for.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "components/elasticity/hexahedron_shapes.h"
#include "components/elasticity/nodal_warping.h"
#include "components/elasticity/quadratic_tetrahedron_models.h"
#include "tests/elasticity/counted.h"
#include "tools/bench/element_operations.h"

namespace stroma::test {
namespace {

constexpr double digits = 1e-9;  // of means over elements, relative to some hundred operations

namespace tetrahedra {

using namespace stroma::tetrahedron;
using stroma::M3;
using stroma::V3;

/// Elements as the benchmarks deform them: a large rotation and strains of some ten per cent.
struct Sample {
  RestShape<Counted> rest;
  /// As far as methods with this update have it.
  template <Update update>
  RestOf<update, Counted> as() const {
    if constexpr (update == Update::none)
      return {rest.g, rest.root};
    else
      return {rest.g, rest.root, {rest.edges[0], rest.edges[1], rest.edges[2]}, rest.inverse_six_volume,
              update == Update::strain_displacement ? Counted() : rest.inverse_six_volume};
  }
  Gradients<Counted> g;
  V3<Counted> x[4];
};

Sample makeSample(std::mt19937& random) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1), angle(-2, 2);
  const double c = std::cos(angle(random)), s = std::sin(angle(random));
  const double rest[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Sample sample;
  for (int a = 0; a < 4; ++a) {
    double p[3];
    for (int i = 0; i < 3; ++i) p[i] = rest[a][i] + noise(random);
    sample.x[a] = {Counted(c * p[0] - s * p[1]), Counted(s * p[0] + c * p[1]), Counted(p[2])};
  }
  sample.rest.inverse_six_volume = Counted(1);
  const Counted one(1), zero(0);
  sample.rest.g = sample.g = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
  sample.rest.edges[0].x = sample.rest.edges[1].y = sample.rest.edges[2].z = one;
  return sample;
}

/// Mean over elements of the operations that `kernel` does.
template <class Kernel>
double meanFlops(Kernel&& kernel) {
  constexpr int count = 1000;
  std::mt19937 random(1);
  long flops = 0;
  for (int i = 0; i < count; ++i) {
    Sample sample = makeSample(random);
    Counted::flops = 0;
    kernel(sample);
    flops += Counted::flops;
  }
  return double(flops) / count;
}

const Counted lambda(2), mu(1);
constexpr double scatter_flops = 12;  // four nodes, three components

/// For large this has 15 flops of the column of F that QR never reads and the compiler leaves out.
template <class Rotation, Update update>
double rotatedForceFlops() {
  return meanFlops([](Sample& s) {
    V3<Counted> f[4];
    const auto k = kinematics<Rotation, update>(s.as<update>(), s.x);
    nodalForces(restoringStress(strainOfKinematics<update>(k.d, k.g, Counted(1)), lambda, mu), k.g, f);
  });
}
template <class Rotation>
double energyFlops() {
  return 1 + meanFlops([](Sample& s) {
           const auto k = kinematics<Rotation, Update::none>(s.as<Update::none>(), s.x);
           storedEnergy(strainOfKinematics<Update::none>(k.d, k.g, Counted(1)), lambda, mu);
         });
}
/// One rotation per node is left out: there are about five elements to a node.
double nodalForceFlops() {
  return meanFlops([](Sample& s) {
    V3<Counted> f[4];
    M3<Counted> r[4];
    nodalWarpingForce(s.g, lambda, mu, s.x, r, f);
    const V3<Counted> e[3] = {s.x[1] - s.x[0], s.x[2] - s.x[0], s.x[3] - s.x[0]};
    outerSum(e, s.g);  // of the pass that collects the nodes' mean deformation gradients
  });
}

double smallForceFlops() {
  return meanFlops([](Sample& s) {
    V3<Counted> f[4];
    const V3<Counted> e[3] = {s.x[1] - s.x[0], s.x[2] - s.x[0], s.x[3] - s.x[0]};
    nodalForces(restoringStress(minusIdentity(strainOf(e, s.g)), lambda, mu), s.g, f);
  });
}

double productFlops(bool nodal) {
  return meanFlops([nodal](Sample& s) {
    V3<Counted> f[4];
    M3<Counted> r[4];
    if (nodal)
      nodalWarpingProduct(s.g, lambda, mu, s.x, r, f);
    else
      stiffnessProduct(Tangent<Counted>{s.g, lambda}, mu, s.x, f);
  });
}

}  // namespace tetrahedra

namespace hexahedra {

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
      for (int p = 0; p < 8; ++p) rest.g[p] = g, rest.scale[p] = one;  // and B alone follows: inverse_determinant is 0
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

template <class Model>
void expectOperations(bench::HexahedronVariant variant) {
  const bench::HexahedronOperations& expected = bench::hexahedron_operations[std::size_t(variant)];
  const double force = meanFlops<Model>([](auto& s) { Model::force(s.rest, s.tangent, s.x, s.f); });
  const double product =
      meanFlops<Model>([](auto& s) { Model::product(s.rest, s.tangent, Counted(1), s.x, s.x, s.f); });
  EXPECT_NEAR(force, expected.force, digits) << int(variant);
  EXPECT_NEAR(product, expected.product, digits) << int(variant);
  const double rest = sizeof(typename Model::template Rest<double>),
               tangent = sizeof(typename Model::template Tangent<double>);
  EXPECT_EQ(rest + tangent, expected.force_bytes) << int(variant);
  EXPECT_EQ(Model::reads_position, expected.product_reads_position) << int(variant);
  EXPECT_EQ(tangent + (Model::reads_position ? rest : 0), expected.product_bytes) << int(variant);
}

}  // namespace hexahedra

namespace quadratic_tetrahedra {

using namespace stroma::quadratic_tetrahedron;
using Model = Corotational<rotation::Polar>;

struct Sample {
  RestGradients<Counted> rest{};
  Tangent<Counted> tangent{};
  V3<Counted> x[nodes], f[nodes];

  explicit Sample(std::mt19937& random) {
    std::uniform_real_distribution<double> noise(-0.05, 0.05), angle(-2, 2);
    const double a = angle(random), c = std::cos(a), s = std::sin(a);
    const double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto place = [&](const double (&p)[3]) {
      return V3<Counted>{Counted(c * p[0] - s * p[1] + noise(random)), Counted(s * p[0] + c * p[1] + noise(random)),
                         Counted(p[2] + noise(random))};
    };
    for (int v = 0; v < 4; ++v) {
      x[v] = place(corners[v]);
      for (int w = 0; w < v; ++w) {
        const double half[3] = {(corners[v][0] + corners[w][0]) / 2, (corners[v][1] + corners[w][1]) / 2,
                                (corners[v][2] + corners[w][2]) / 2};
        x[middle[v][w]] = place(half);
      }
    }
    const Counted one(1), zero(0);
    for (int p = 0; p < points; ++p) rest.g[p] = tangent.g[p] = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
  }
};

constexpr double scatter_flops = 30;  // ten nodes, three components

template <class Kernel>
double meanFlops(Kernel&& kernel) {
  constexpr int count = 200;
  std::mt19937 random(1);
  long flops = 0;
  for (int i = 0; i < count; ++i) {
    Sample sample(random);
    Counted::flops = 0;
    kernel(sample);
    flops += Counted::flops;
  }
  return scatter_flops + double(flops) / count;
}

}  // namespace quadratic_tetrahedra

TEST(Operations, OfTetrahedraAreThoseOfTheBenchmarks) {
  using namespace tetrahedra;
  const auto of = [](const char* method) {
    for (const bench::TetrahedronOperations& each : bench::tetrahedron_operations)
      if (each.method == method) return each;
    return bench::TetrahedronOperations{};
  };
  EXPECT_NEAR(smallForceFlops() + scatter_flops, of("small").force, digits);
  EXPECT_NEAR((rotatedForceFlops<rotation::Qr, Update::none>()) + scatter_flops, of("large").force, digits);
  EXPECT_NEAR((rotatedForceFlops<rotation::Polar, Update::none>()) + scatter_flops, of("polar").force, digits);
  EXPECT_NEAR((rotatedForceFlops<rotation::Svd, Update::none>()) + scatter_flops, of("svd").force, digits);
  EXPECT_NEAR(nodalForceFlops() + 4 * 9 + scatter_flops, of("nodal").force, digits);
  const double large = rotatedForceFlops<rotation::Qr, Update::none>(),
               updated = rotatedForceFlops<rotation::Qr, Update::strain_displacement>(),
               all_updated = rotatedForceFlops<rotation::Qr, Update::strain_displacement_and_volume>();
  EXPECT_NEAR(updated - large, bench::updated_gradients, digits);
  EXPECT_NEAR(all_updated - updated, bench::updated_volume, digits);
  for (const bench::TetrahedronOperations& each : bench::tetrahedron_operations)
    EXPECT_NEAR(productFlops(each.method == "nodal") + scatter_flops, each.product, digits) << each.method;
  EXPECT_NEAR(energyFlops<rotation::Polar>(), bench::polar_energy, digits);
}

TEST(Operations, OfHexahedraAreThoseOfTheBenchmarks) {
  using namespace hexahedra;
  using bench::HexahedronVariant;
  using rotation::Polar;
  expectOperations<ModalCorotational<Boxes, Polar>>(HexahedronVariant::polar_boxes);
  expectOperations<PointCorotational<LocalDilatation, Polar, Update::strain_displacement>>(HexahedronVariant::polar_b);
  expectOperations<elastic::GreenModel<BoxShape, false>>(HexahedronVariant::green);
}

TEST(Operations, OfQuadraticTetrahedraAreThoseOfTheBenchmarks) {
  using namespace quadratic_tetrahedra;
  const bench::QuadraticOperations& expected = bench::quadratic_operations;
  EXPECT_NEAR(meanFlops([](Sample& s) { Model::force(s.rest, s.tangent, s.x, s.f); }), expected.force, digits);
  EXPECT_NEAR(meanFlops([](Sample& s) { Model::product(s.rest, s.tangent, Counted(1), s.x, s.x, s.f); }), expected.product, digits);
  EXPECT_EQ(sizeof(Tangent<double>), expected.product_bytes);
  EXPECT_EQ(sizeof(RestGradients<double>) + sizeof(Tangent<double>), expected.force_bytes);
}

}  // namespace
}  // namespace stroma::test
