// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"

namespace stroma::bench {
namespace {

constexpr double elements = 20480, nodes = 4913;

/// A law as the scene gets it, SOFA's time per step on the same body and machine [ms], and what its product cannot do
/// without: numbers read an element besides the six of its gradients, and flops (a multiply-add counts two) by the
/// formulas of framework/fem/hyperelastic_invariants.h.
struct Law {
  std::string name, parameters, directions;
  double sofa, product_numbers, product_flops;
};
const std::vector<Law>& laws() {
  // F and dF 2 x 36, P g_i 45; J part 100; dF S + F dS 108; C 36, dC 54; I1 and I2 part 30; rotations of Ogden 162
  static const std::vector<Law> all{{"StVenantKirchhoff", "10000 40000", "", 9.7, 3, 390},
                                    {"NeoHookean", "10000 40000", "", 21, 3, 250},
                                    {"StableNeoHookean", "10000 40000", "", 0, 3, 250},
                                    {"MooneyRivlin", "3000 2000 46000", "", 42, 8, 510},
                                    {"Costa", "5000 46000 4 2 2 2 2 2", "1 1 0 0 0 1", 68, 19, 540},
                                    {"VerondaWestman", "5000 2 46000", "", 89, 8, 510},
                                    {"TransverselyIsotropic", "10000 40000 10000 1", "1 1 0", 0, 12, 290},
                                    {"ArrudaBoyce", "10000 46000", "", 138, 5, 260},
                                    {"Ogden", "20000 3 46000", "", 1927, 23, 690}};
  return all;
}

enum class Part { force, product, force_and_product, assembly, step };
const char* wordOf(Part part) {
  constexpr const char* words[] = {"force", "product", "force and product", "assembly", "step"};
  return words[int(part)];
}

struct Form {
  Law law;
  Part part;
  std::string discretization;
};

void time(benchmark::State& state, const Form& form) {
  setThreads(1);
  const std::string field = "/cube/cells/fem.";
  Body& body =
      bodyOf("benchmarks/hyperelastic.xml",
             {field + "materialName=" + form.law.name, field + "ParameterSet=" + form.law.parameters,
              field + "discretization=" + form.discretization, field + "AnisotropyDirections=" + form.law.directions},
             Shape::deformed);
  if (body.elements != elements || body.x.count() != Index(nodes)) {
    state.SkipWithError("the scene has another number of elements or nodes than the figure is made for");
    return;
  }
  static double factor = 1;
  const auto call = [&] {
    if (form.part == Part::force) body.field->addForce(body.x, body.v, body.f);
    if (form.part == Part::product) body.field->addStiffnessProduct(body.dx, 1e-6, body.df);
    if (form.part == Part::force_and_product) body.field->addForceAndProduct(body.x, body.v, body.dx, 1e-6, body.f);
    if (form.part == Part::assembly) {
      factor = factor == 1 ? 1.5 : 1;
      benchmark::DoNotOptimize(
          body.system->matrix().withFactors({.mass = 1, .stiffness = -factor}).assemble().values().data());
    }
    if (form.part == Part::step && body.simulation->step().diverged) state.SkipWithError("the step diverged");
  };
  for (auto _ : state) call();
}

void add(Catalogue& catalogue, const Form& form) {
  Figure figure;
  const bool step = form.part == Part::step;
  figure.name = fmt::format("hyperelastic {} {}{}", wordOf(form.part), form.law.name,
                            form.discretization == "standard" ? ", standard" : "");
  figure.unit = step ? "ms/step" : "ns/tet";
  figure.per_second = step ? 1e3 : 1e9 / elements;
  if (step && form.law.sofa > 0 && form.discretization == "mjed") {
    figure.target = form.law.sofa / 5;
    figure.peers = fmt::format("SOFA {}", form.law.sofa);
  }
  if (form.part == Part::product && form.discretization == "mjed") {
    // gradients and tangent, node numbers of two cells in a fan, x and dx read, df read and written
    const double share = nodes / elements * 4 * 32, bytes = 8 * (6 + form.law.product_numbers) + 4 * 2.5 + share;
    figure.work = Work{bytes, form.law.product_flops} * elements;
    figure.working_set = figure.work.bytes;
  }
  catalogue.add(figure, [form](benchmark::State& state) { time(state, form); });
}

}  // namespace

void addHyperelasticFigures(Catalogue& catalogue) {
  for (const Law& law : laws())
    for (const std::string discretization : {"mjed", "standard"})
      for (const Part part : {Part::force, Part::product, Part::force_and_product, Part::assembly, Part::step})
        add(catalogue, {law, part, discretization});
}

}  // namespace stroma::bench
