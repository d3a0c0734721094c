// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"

namespace stroma::bench {
namespace {

struct Form {
  std::string name, reaction;
  int side;  ///< nodes along an edge of the cube
  bool whole_step;
  double nodes() const { return double(side) * side * side; }
};

Body& bodyOf(const Form& form) {
  return bodyOf("benchmarks/shape_memory.xml",
                {fmt::format("/grid.n={0} {0} {0}", form.side), "/cells/memory.reaction=" + form.reaction},
                Shape::deformed);
}

void time(benchmark::State& state, const Form& form) {
  setThreads(1);
  Body& body = bodyOf(form);
  if (double(body.x.count()) != form.nodes()) {
    state.SkipWithError("the scene has another number of nodes than the figure is made for");
    return;
  }
  if (form.whole_step) {
    copy(body.x, body.system->x);
    for (auto _ : state)
      if (body.simulation->step().diverged) state.SkipWithError("the step diverged");
  } else {
    for (auto _ : state) body.field->addForce(body.x, body.v, body.f);
  }
}

}  // namespace

void addShapeMemoryFigures(Catalogue& catalogue) {
  for (const int side : {10, 31})
    for (const auto& [words, reaction] : {std::pair{"", "false"}, std::pair{" with reaction", "true"}})
      for (const bool whole_step : {false, true}) {
        const Form form{fmt::format("shape memory {}{}, {}", whole_step ? "step" : "force", words,
                                    side == 10 ? "1k nodes" : "30k nodes"),
                        reaction, side, whole_step};
        Figure figure;
        figure.name = form.name;
        figure.unit = "ns/node";
        figure.per_second = 1e9 / form.nodes();
        figure.target = 40;
        figure.peers = "the paper, 2005: 17,000 an iteration";
        catalogue.add(figure, [form](benchmark::State& state) { time(state, form); });
      }
}

}  // namespace stroma::bench
