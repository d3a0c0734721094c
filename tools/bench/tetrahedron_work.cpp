// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/tetrahedron_work.h"

#include <algorithm>

#include "tools/bench/element_operations.h"

namespace stroma::bench {
namespace {

const TetrahedronOperations& operationsOf(const Variant& variant) {
  return *std::find_if(tetrahedron_operations.begin(), tetrahedron_operations.end(),
                       [&variant](const TetrahedronOperations& each) { return each.method == variant.method; });
}

double forceFlops(const Variant& variant) {
  const double updated = variant.update_volume ? updated_gradients + updated_volume
                         : variant.update_b    ? updated_gradients
                                               : 0;
  return operationsOf(variant).force + updated;
}

double productFlops(const Variant& variant) { return operationsOf(variant).product; }

constexpr double scatter_flops = 12;  // four nodes, three components
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
  return {node_numbers + material + restBytes(variant) + vector_row * nodes, polar_energy};
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
