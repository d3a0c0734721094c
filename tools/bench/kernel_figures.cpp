// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include <map>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"
#include "tools/bench/tetrahedron_work.h"

namespace stroma::bench {
namespace {

/// A mesh of scenes/benchmarks. The numbers of elements and nodes are checked when it is loaded.
struct Block {
  std::string word, scene;
  double i, j, k;  ///< cells of the grid in x, y, z
  double elements() const { return 5 * i * j * k; }
  double nodes() const { return (i + 1) * (j + 1) * (k + 1); }
  double nodesPerElement() const { return nodes() / elements(); }
  /// 3x3 blocks of the matrix: the nodes, and twice the edges (those of the grid, and a diagonal in each of its faces).
  double matrixBlocks() const {
    const double edges = i * (j + 1) * (k + 1) + (i + 1) * j * (k + 1) + (i + 1) * (j + 1) * k;
    const double faces = i * j * (k + 1) + i * (j + 1) * k + (i + 1) * j * k;
    return nodes() + 2 * (edges + faces);
  }
};
const Block small_block{"10k", "benchmarks/block_10000.xml", 20, 10, 10};
const Block large_block{"320k", "benchmarks/block_320000.xml", 40, 40, 40};

std::vector<std::string> overridesFor(const Variant& variant, const std::string& tangent) {
  const std::string field = "/block/cells/fem.";
  std::vector<std::string> overrides{field + "method=" + variant.method, field + "tangent=" + tangent};
  if (variant.update_b) overrides.push_back(field + "updateStiffnessMatrix=true");
  if (variant.update_volume) overrides.push_back(field + "updateVolume=true");
  return overrides;
}

/// What a benchmark times; one call before makes what it needs.
using Call = void (*)(Body&);

struct Kernel {
  std::string name;
  const Block& block;
  Variant variant;
  Call call;
  Work work;  ///< of one element
  std::optional<double> target = {};
  Shape shape = Shape::deformed;
  std::string tangent = "warped";
  int threads = 1;
};

void time(benchmark::State& state, const Kernel& kernel) {
  setThreads(kernel.threads);
  Body& body = bodyOf(kernel.block.scene, overridesFor(kernel.variant, kernel.tangent), kernel.shape);
  if (body.elements != kernel.block.elements() || body.x.count() != Index(kernel.block.nodes())) {
    state.SkipWithError("the scene has another number of elements or nodes than the figure is made for");
    return;
  }
  clear(body.f);
  clear(body.df);
  kernel.call(body);
  for (auto _ : state) kernel.call(body);
  if (kernel.shape == Shape::crumpled)
    state.SetLabel(fmt::format("{:.0f} % of the elements inverted", 100 * body.invertedShare()));
  setThreads(1);
}

void add(Catalogue& catalogue, const Kernel& kernel) {
  Figure figure;
  figure.name = kernel.name;
  figure.unit = "ns/tet";
  figure.per_second = 1e9 / kernel.block.elements();
  figure.target = kernel.target;
  figure.work = kernel.work * kernel.block.elements();
  figure.working_set = figure.work.bytes;
  figure.wall = kernel.block.elements() > 1e5;  // ratios of one and two threads are of one clock
  catalogue.add(figure, [kernel](benchmark::State& state) { time(state, kernel); });
}

void product(Body& body) { body.field->addStiffnessProduct(body.dx, 1e-6, body.df); }
void force(Body& body) { body.field->addForce(body.x, body.v, body.f); }
void forceAndProduct(Body& body) { body.field->addForceAndProduct(body.x, body.v, body.dx, 1e-6, body.f); }
void energy(Body& body) { benchmark::DoNotOptimize(body.field->energy(body.x)); }
// Changing the factor makes the system assemble again; the projection of fixed nodes is part of it.
void assembly(Body& body) {
  static double factor = 1;
  factor = factor == 1 ? 1.5 : 1;
  benchmark::DoNotOptimize(
      body.system->matrix().withFactors({.mass = 1, .stiffness = -factor}).assemble().values().data());
}
void assembledProduct(Body& body) {
  body.system->matrix().withFactors({.mass = 1, .stiffness = -1}).assemble().multiply(body.dx, body.df);
  benchmark::ClobberMemory();
}

/// 76 bytes and 18 flops a block; x read and y written.
Work assembledProductWork(const Block& block) {
  return Work{block.matrixBlocks() * 76 + block.nodes() * 64, block.matrixBlocks() * 18} * (1 / block.elements());
}

const char* variantWord(const Variant& variant) {
  return variant.update_volume ? ", B and V" : variant.update_b ? ", B" : "";
}

void addForces(Catalogue& catalogue, const Block& block) {
  const std::map<std::string, double> targets{{"large", 20}, {"polar", 35}, {"svd", 70}};
  std::vector<Variant> variants{{"small"}, {"nodal"}};
  for (const char* method : {"large", "polar", "svd"})
    for (int update = 0; update < 3; ++update) variants.push_back({method, update > 0, update > 1});
  for (const Variant& variant : variants) {
    std::optional<double> target;
    if (const auto found = targets.find(variant.method); found != targets.end()) target = found->second;
    add(catalogue, {fmt::format("force {} {}{}", block.word, variant.method, variantWord(variant)), block, variant,
                    force, forceWork(variant, block.nodesPerElement()), target});
  }
}

}  // namespace

void addKernelFigures(Catalogue& catalogue) {
  const Block& block = small_block;
  const double share = block.nodesPerElement();
  const Variant large{"large"}, polar{"polar"}, svd{"svd"}, nodal{"nodal"};
  add(catalogue, {"product 10k", block, large, product, productWork(large, share), 5.0});
  add(catalogue, {"product 10k nodal", block, nodal, product, productWork(nodal, share)});
  add(catalogue, {"product 10k svd, exact tangent", block, svd, product, {}, {}, Shape::deformed, "exact"});
  addForces(catalogue, block);
  for (const Variant& variant : {polar, svd})
    add(catalogue,
        {fmt::format("force 10k {}, crumpled", variant.method), block, variant, force, {}, {}, Shape::crumpled});
  for (const char* method : {"small", "large", "polar", "svd"}) {
    const Variant variant{method};
    add(catalogue, {fmt::format("force and product 10k {}", method), block, variant, forceAndProduct,
                    forceAndProductWork(variant, share)});
  }
  add(catalogue, {"energy 10k polar", block, polar, energy, polarEnergyWork(share)});
  add(catalogue,
      {"assembly 10k", block, large, assembly, assemblyWork(large, block.matrixBlocks() / block.elements())});
  add(catalogue, {"assembled product 10k", block, large, assembledProduct, assembledProductWork(block)});

  const double large_share = large_block.nodesPerElement();
  add(catalogue, {"product 320k", large_block, large, product, productWork(large, large_share), 6.0});
  add(catalogue, {"assembled product 320k", large_block, large, assembledProduct, assembledProductWork(large_block)});
  add(catalogue, {"force 320k large", large_block, large, force, forceWork(large, large_share)});
  add(catalogue, {"force 320k polar", large_block, polar, force, forceWork(polar, large_share)});
}

void addThreadFigures(Catalogue& catalogue) {
  const double share = large_block.nodesPerElement();
  const Variant polar{"polar"};
  add(catalogue, {"product 320k, 2 threads",
                  large_block,
                  polar,
                  product,
                  productWork(polar, share) * 0.5,
                  {},
                  Shape::deformed,
                  "warped",
                  2});
  add(catalogue, {"force 320k polar, 2 threads",
                  large_block,
                  polar,
                  force,
                  forceWork(polar, share) * 0.5,
                  {},
                  Shape::deformed,
                  "warped",
                  2});
  catalogue.addRatio({"product 320k: 1 thread / 2 threads", "product 320k", "product 320k, 2 threads", 1.7});
  catalogue.addRatio(
      {"force 320k polar: 1 thread / 2 threads", "force 320k polar", "force 320k polar, 2 threads", 1.7});
}

}  // namespace stroma::bench
