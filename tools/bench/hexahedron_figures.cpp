// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "tools/bench/body.h"
#include "tools/bench/figures.h"
#include "tools/bench/hexahedron_work.h"

namespace stroma::bench {
namespace {

/// A cube of hexahedra: cells along each edge.
struct Cube {
  const char* word;
  int cells;
  double elements() const { return double(cells) * cells * cells; }
  double nodesPerElement() const { return double(cells + 1) * (cells + 1) * (cells + 1) / elements(); }
};
constexpr Cube small_cube{"1k", 10}, large_cube{"64k", 40};

struct Method {
  const char* word;
  HexahedronVariant variant;
  std::vector<std::string> overrides;
};
const std::vector<Method>& methods() {
  static const std::vector<Method> all{
      {"polar", HexahedronVariant::polar_boxes, {}},
      {"polar, B", HexahedronVariant::polar_b, {"/cube/fem.updateStiffnessMatrix=true"}},
      {"green", HexahedronVariant::green, {"/cube/fem.method=green"}}};
  return all;
}

using Call = void (*)(Body&);

void add(Catalogue& catalogue, const char* what, const Cube& cube, const Method& method, Call call, Work work) {
  Figure figure;
  figure.name = fmt::format("hexahedra {} {} {}", what, cube.word, method.word);
  figure.unit = "ns/hex";
  figure.per_second = 1e9 / cube.elements();
  figure.work = work * cube.elements();
  figure.working_set = figure.work.bytes;
  std::vector<std::string> overrides = method.overrides;
  overrides.push_back(fmt::format("/cube/grid.n={0} {0} {0}", cube.cells + 1));
  catalogue.add(figure, [overrides, call](benchmark::State& state) {
    Body& body = bodyOf("benchmarks/hexahedra.xml", overrides, Shape::deformed);
    clear(body.f), clear(body.df);
    call(body);
    for (auto _ : state) call(body);
  });
}

void multiplyByHexahedra(Body& body) { body.field->addStiffnessProduct(body.dx, 1e-6, body.df); }
void addHexahedronForce(Body& body) { body.field->addForce(body.x, body.v, body.f); }
// The change of the factor makes the system assemble anew; the projection of held nodes is part of it.
void assembleHexahedra(Body& body) {
  static double factor = 1;
  factor = factor == 1 ? 1.5 : 1;
  benchmark::DoNotOptimize(
      body.system->matrix().withFactors({.mass = 1, .stiffness = -factor}).assemble().values().data());
}

}  // namespace

void addHexahedronFigures(Catalogue& catalogue) {
  for (const Cube& cube : {small_cube, large_cube}) {
    const double share = cube.nodesPerElement();
    for (const Method& method : methods()) {
      add(catalogue, "product", cube, method, multiplyByHexahedra, hexahedronProductWork(method.variant, share));
      add(catalogue, "force", cube, method, addHexahedronForce, hexahedronForceWork(method.variant, share));
      add(catalogue, "assembly", cube, method, assembleHexahedra, {});
    }
  }
  const Method exact{"svd, exact tangent", {}, {"/cube/linear=SparseLDLSolver", "/cube/fem.method=svd", "/cube/fem.tangent=exact"}};
  add(catalogue, "product", small_cube, exact, multiplyByHexahedra, {});
  add(catalogue, "assembly", small_cube, exact, assembleHexahedra, {});
}

}  // namespace stroma::bench
