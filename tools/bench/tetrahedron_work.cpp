// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/tetrahedron_work.h"

#include <array>
#include <random>

#include "components/elasticity/nodal_warping.h"
#include "tools/bench/counted.h"

namespace stroma::bench {
namespace {

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
      return rest;
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
template <class Rotation>
double rotatedForceFlops(const Variant& variant) {
  if (variant.update_volume) return rotatedForceFlops<Rotation, Update::strain_displacement_and_volume>();
  if (variant.update_b) return rotatedForceFlops<Rotation, Update::strain_displacement>();
  return rotatedForceFlops<Rotation, Update::none>();
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

double forceFlops(const Variant& variant) {
  if (variant.method == "nodal") return nodalForceFlops() + 4 * 9 + scatter_flops;
  if (variant.method == "large") return rotatedForceFlops<rotation::Qr>(variant) + scatter_flops;
  if (variant.method == "polar") return rotatedForceFlops<rotation::Polar>(variant) + scatter_flops;
  if (variant.method == "svd") return rotatedForceFlops<rotation::Svd>(variant) + scatter_flops;
  return scatter_flops + meanFlops([](Sample& s) {
           V3<Counted> f[4];
           const V3<Counted> e[3] = {s.x[1] - s.x[0], s.x[2] - s.x[0], s.x[3] - s.x[0]};
           nodalForces(restoringStress(minusIdentity(strainOf(e, s.g)), lambda, mu), s.g, f);
         });
}

double productFlops(const Variant& variant) {
  return scatter_flops + meanFlops([&](Sample& s) {
           V3<Counted> f[4];
           M3<Counted> r[4];
           if (variant.method == "nodal")
             nodalWarpingProduct(s.g, lambda, mu, s.x, r, f);
           else
             stiffnessProduct(Tangent<Counted>{s.g, lambda}, mu, s.x, f);
         });
}

constexpr double number = sizeof(double);
constexpr double node_numbers = 2.5 * 4;   // 32-bit integers; two elements share three
constexpr double gradients = 9 * number;   // g_1, g_2, g_3
constexpr double material = 2 * number;    // lambda/mu and the root of mu V, or lambda V and mu V
constexpr double ratio = number;           // lambda/mu: gradients that a product reads hold the rest
constexpr double vector_row = 4 * number;  // x, y, z and the padding
constexpr double block = 9 * number;       // of an assembled matrix
constexpr double node_rotation = 3 * vector_row;

/// What the force has to know of an element's rest shape; the code reads half as much again.
double restBytes(const Variant& variant) {
  if (variant.method == "small" || variant.method == "nodal") return gradients;
  return (variant.update_b ? 6 + 6 + 1 : 6) * number;
}

}  // namespace

Work productWork(const Variant& variant, double nodes) {
  double bytes = node_numbers + gradients + ratio + 3 * vector_row * nodes;  // dx read, df read and written
  if (variant.method == "nodal") bytes += number + node_rotation * nodes;
  return {bytes, productFlops(variant)};
}

Work forceWork(const Variant& variant, double nodes) {
  double bytes = node_numbers + material + restBytes(variant) + 3 * vector_row * nodes;
  if (variant.method == "nodal")  // a pass before it, which makes the rotations
    bytes += node_numbers + gradients + material + (vector_row + 4 * node_rotation) * nodes;
  else if (variant.method != "small")
    bytes += gradients;  // written for the products
  return {bytes, forceFlops(variant)};
}

Work forceAndProductWork(const Variant& variant, double nodes) {
  const Work force = forceWork(variant, nodes), product = productWork(variant, nodes);
  if (variant.method == "nodal") return force + product;
  // the element, the strain and the sums are shared: three differences of dx are added to those of x
  return {force.bytes + vector_row * nodes, force.flops + 3 * 3 + 3 * 3 * 2};
}

Work polarEnergyWork(double nodes) {
  const Variant variant{"polar"};
  return {node_numbers + material + restBytes(variant) + vector_row * nodes, energyFlops<rotation::Polar>()};
}

Work assemblyWork(const Variant& variant, double blocks) {
  constexpr double slots = 16 * 4;
  // nine products give the matrix; scaled, summed for node 0 and added to 16 blocks
  return {node_numbers + gradients + ratio + slots + 3 * block * blocks,
          9 * (productFlops(variant) - scatter_flops) + 9 * 4 * 3 * 2 + 16 * 9};
}

Work conjugateGradientWork() {
  // p.q with p.p and q.q; r -= alpha q with r.r; x += alpha p with p = z + beta p: ten rows read or written
  return {10 * vector_row, 3 * (6 + 4 + 4)};
}

}  // namespace stroma::bench
