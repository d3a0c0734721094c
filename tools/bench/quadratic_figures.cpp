// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "tools/bench/body.h"
#include "tools/bench/element_operations.h"
#include "tools/bench/figures.h"

namespace stroma::bench {
namespace quadratic {

/// A beam of 20 x 4 x 4 cells of six tetrahedra of ten nodes: what a product reads stays in a level-2 cache of 2 MB.
constexpr int cells[3] = {20, 4, 4};
constexpr double elements = 6. * cells[0] * cells[1] * cells[2];
constexpr double nodes_per_element = (2 * cells[0] + 1) * (2 * cells[1] + 1) * (2 * cells[2] + 1) / elements;
constexpr double node_numbers = 10 * 4, vector_row = 4 * sizeof(double);

struct Method {
  const char* word;
  const char* tangent;
};
constexpr Method methods[] = {{"polar", "warped"}, {"svd", "exact"}, {"green", "exact"}};

/// Of method polar.
static Work workOf(bool is_force) {
  const QuadraticOperations& each = quadratic_operations;
  if (is_force) return {node_numbers + each.force_bytes + 3 * vector_row * nodes_per_element, each.force};
  return {node_numbers + each.product_bytes + 3 * vector_row * nodes_per_element, each.product};
}

static ForceField& fieldOf(Body& body) {
  for (ForceField* field : body.system->forceFields())
    if (field->name() == "fem") return *field;
  return *body.field;
}
static void addForceOf(Body& body) { fieldOf(body).addForce(body.x, body.v, body.f); }

using Call = void (*)(Body&);
static void add(Catalogue& catalogue, const char* what, const Method& method, Call call, Work work) {
  Figure figure;
  figure.name = fmt::format("quadratic tetrahedra {} {}", what, method.word);
  figure.unit = "ns/tet";
  figure.per_second = 1e9 / elements;
  figure.work = work * elements;
  figure.working_set = figure.work.bytes;
  const std::vector<std::string> overrides{
      fmt::format("/beam/grid.n={} {} {}", cells[0] + 1, cells[1] + 1, cells[2] + 1),
      fmt::format("/beam/raised/fem.method={}", method.word), fmt::format("/beam/raised/fem.tangent={}", method.tangent)};
  catalogue.add(figure, [overrides, call](benchmark::State& state) {
    Body& body = bodyOf("benchmarks/cantilever_quadratic.xml", overrides, Shape::deformed);
    clear(body.f), clear(body.df);
    addForceOf(body);  // a body has evaluated its first field alone
    call(body);
    for (auto _ : state) call(body);
  });
}

static void multiply(Body& body) { fieldOf(body).addStiffnessProduct(body.dx, 1e-6, body.df); }
// Changing the factor makes the system assemble again; the projection of fixed nodes is part of it.
static void assemble(Body& body) {
  static double factor = 1;
  factor = factor == 1 ? 1.5 : 1;
  benchmark::DoNotOptimize(body.system->matrix().withFactors({.mass = 1, .stiffness = -factor}).assemble().values().data());
}

static void addAll(Catalogue& catalogue) {
  for (const Method& method : methods) {
    const bool is_counted = std::string_view(method.word) == "polar";
    add(catalogue, "product", method, multiply, is_counted ? workOf(false) : Work{});
    add(catalogue, "force", method, addForceOf, is_counted ? workOf(true) : Work{});
    add(catalogue, "assembly", method, assemble, {});
  }
}

}  // namespace quadratic

void addQuadraticFigures(Catalogue& catalogue) { quadratic::addAll(catalogue); }

}  // namespace stroma::bench
