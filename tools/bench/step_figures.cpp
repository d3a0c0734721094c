// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"
#include "tools/bench/hexahedron_work.h"
#include "tools/bench/tetrahedron_work.h"

namespace stroma::bench {
namespace {

constexpr int warm_up_steps = 20;

struct Scene {
  std::string name, file;
  std::vector<std::string> overrides;
  std::optional<double> target = {};
  std::string peers = {};
  Work work = {};
  double working_set = 0;
  bool is_direct = false;  ///< the work is that of the factors, which the solver tells after a step
};

void time(benchmark::State& state, const Scene& scene, Figure& figure) {
  setThreads(1);
  Simulation& simulation = keptSimulation(scene.name, warm_up_steps, scene.file, scene.overrides);
  if (scene.is_direct) {
    figure.work = factorWork(simulation);
    figure.working_set = figure.work.bytes / 3;
  }
  long iterations = 0, factorisations = 0, steps = 0;
  for (auto _ : state) {
    const StepReport report = simulation.step();
    if (report.diverged) {
      state.SkipWithError(report.reason.c_str());
      break;
    }
    iterations += report.linear_iterations, factorisations += report.factorisations, ++steps;
  }
  if (steps == 0) return;
  const double each = 1 / double(steps);
  state.SetLabel(factorisations ? fmt::format("{:.3g} factorisations per step", double(factorisations) * each)
                                : fmt::format("{:.3g} CG iterations per step", double(iterations) * each));
}

void add(Catalogue& catalogue, const Scene& scene) {
  Figure figure;
  figure.name = "step " + scene.name;
  figure.unit = "ms/step";
  figure.per_second = 1e3;
  figure.target = scene.target;
  figure.peers = scene.peers;
  figure.work = scene.work;
  figure.working_set = scene.working_set;
  catalogue.add(figure, [scene, &catalogue](benchmark::State& state) {
    time(state, scene, catalogue.find("step " + scene.name)->figure);
  });
}

/// One force with its product, then `iterations` products and the vectors of conjugate gradients.
Work stepWork(const Variant& variant, double elements, double nodes, int iterations) {
  const double share = nodes / elements;
  return forceAndProductWork(variant, share) * elements + productWork(variant, share) * (elements * iterations) +
         conjugateGradientWork() * (nodes * iterations);
}

Work hexahedronStepWork(HexahedronVariant variant, double elements, double nodes, int iterations) {
  const double share = nodes / elements;
  return hexahedronForceWork(variant, share) * elements +
         hexahedronProductWork(variant, share) * (elements * (iterations + 1)) +
         conjugateGradientWork() * (nodes * iterations);
}

/// Steps that read numbers computed beforehand and hardly anything else: 1,009 kept nodes.
void addCondensedFigures(Catalogue& catalogue) {
  const double rows = 3 * 1009;
  const Work columns{9 * 8 * rows, 2 * 9 * rows}, half{8 * rows * rows / 2, 2 * rows * rows};
  add(catalogue,
      {"condensed static, 3 of 1,009", "benchmarks/condensed_static.xml", {}, 0.02, "", columns, columns.bytes});
  add(catalogue, {"condensed dynamic, 1,009", "benchmarks/condensed_dynamic.xml", {}, {}, "", half, half.bytes});
  add(catalogue, {"condensed dynamic, 1,009, single",
                  "benchmarks/condensed_dynamic.xml",
                  {"/block/solver.precision=single"},
                  {},
                  "",
                  {half.bytes / 2, half.flops},
                  half.bytes / 2});
}

}  // namespace

void addStepFigures(Catalogue& catalogue) {
  const double nodes = 11 * 11 * 11, element_bytes = 200;  // tangent, rest shape and node numbers
  struct Row {
    const char *method, *peers;
    double target;
  };
  for (const Row& row : {Row{"small", "SOFA 1.6", 0.22}, Row{"large", "SOFA 2.0, SOFA edge-based 1.1", 0.22},
                         Row{"polar", "SOFA 3.9, Vega FEM assembled 3.6", 0.40}, Row{"svd", "SOFA 3.5", 0.60}})
    add(catalogue, {fmt::format("cube 5,000 {}", row.method),
                    "benchmarks/cube.xml",
                    {fmt::format("/cube/cells/fem.method={}", row.method)},
                    row.target,
                    row.peers,
                    stepWork({row.method}, 5000, nodes, 5),
                    5000 * element_bytes});
  add(catalogue, {"cube 5,000 large, direct", "benchmarks/cube_direct.xml", {}, 12.0, "SOFA 60", {}, 0, true});
  for (const Row& row : {Row{"polar", "the paper, 2005: 80", 0.8}, Row{"large", "the paper, 2005: 58", 0.7}})
    add(catalogue, {fmt::format("truth cube {}, B", row.method),
                    "benchmarks/truth_cube.xml",
                    {fmt::format("/cube/cells/fem.method={}", row.method)},
                    row.target,
                    row.peers,
                    stepWork({row.method, true}, 10000, nodes, 5),
                    10000 * element_bytes});
  struct HexahedronRow {
    const char *word, *update, *peers;
    HexahedronVariant variant;
    double target, element_bytes;
  };
  for (const HexahedronRow& row :
       {HexahedronRow{"polar", "false", "SOFA 1.4", HexahedronVariant::polar_boxes, 0.28, 170},
        HexahedronRow{"polar, B", "true", "SOFA 5.5", HexahedronVariant::polar_b, 1.0, 624}})
    add(catalogue, {fmt::format("hexahedra 1,000 {}", row.word),
                    "benchmarks/hexahedra.xml",
                    {fmt::format("/cube/fem.updateStiffnessMatrix={}", row.update)},
                    row.target,
                    row.peers,
                    hexahedronStepWork(row.variant, 1000, nodes, 5),
                    1000 * row.element_bytes});
  addCondensedFigures(catalogue);
  add(catalogue, {"organ, 600", "examples/organ.xml", {}});
  add(catalogue, {"organ, 5,000", "examples/organ_fine.xml", {}});
}

}  // namespace stroma::bench
