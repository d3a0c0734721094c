// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include <cmath>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"

namespace stroma::bench {
namespace {

struct MemoryForm {
  std::string name, reaction;
  int side;  ///< nodes along an edge of the cube
  bool whole_step;
  double nodes() const { return double(side) * side * side; }

  /// A node of a grid cut in five has twelve neighbours in the mean (18 and 6 in turn). Bytes: rows of 32 of x and f,
  /// an index for each neighbour; of reactions the row that neighbours read, and their indices; of a step v and x.
  /// Operations: the sums over neighbours, with the outer products and the reactions' rows at the border, where nodes
  /// have frames; the rotations themselves are not counted.
  Work work() const {
    constexpr double neighbours = 12, row = 32, index = 4;
    const double framed = 1 - std::pow((side - 2.) / side, 3);
    const bool reacts = reaction == "true";
    Work node{2 * row + index * (neighbours + 1), neighbours * (6 + 18 * framed)};
    if (reacts) node = node + Work{2 * row + index * neighbours, neighbours * (3 + 9 * framed)};
    if (whole_step) node = node + Work{3 * row, 12};
    return node * nodes();
  }
};

Body& bodyOf(const MemoryForm& form) {
  return bodyOf("benchmarks/shape_memory.xml",
                {fmt::format("/grid.n={0} {0} {0}", form.side), "/cells/memory.reaction=" + form.reaction},
                Shape::deformed);
}

void time(benchmark::State& state, const MemoryForm& form) {
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
        const MemoryForm form{fmt::format("shape memory {}{}, {}", whole_step ? "step" : "force", words,
                                    side == 10 ? "1k nodes" : "30k nodes"),
                        reaction, side, whole_step};
        Figure figure;
        figure.name = form.name;
        figure.unit = "ns/node";
        figure.per_second = 1e9 / form.nodes();
        figure.target = 40;
        figure.work = form.work();
        figure.working_set = figure.work.bytes;
        figure.peers = "the paper, 2005: 17,000 per iteration";
        catalogue.add(figure, [form](benchmark::State& state) { time(state, form); });
      }
}

}  // namespace stroma::bench
