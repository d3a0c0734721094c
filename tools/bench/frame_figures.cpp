// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"

namespace stroma::bench {
namespace {

constexpr int frames = 1000;  // of scenes/benchmarks/chain.xml
constexpr int chain_steps_before = 200;
const std::string beams = R"(<BeamFEMForceField name="beams" radius="0.01" youngModulus="1e5" poissonRatio="0.3"/>)";

/// What is between the frames of a chain.
struct Chain {
  std::string name;
  Work joint;  ///< of one pair
  std::vector<Replacement> parts;
  bool implicit = false;
};

/// Bytes: two rows of x and v each, read and written. Operations: of the velocities 12, of the places 9, of the series of a turn,
/// the product of two quaternions and its length 71, of masses 6; counted by hand from the formulas.
constexpr Work frame_work{2 * 2 * 2 * 32, 98};
/// The axes of both ends, the numbers of the nodes and the length; of joints the axes of one end, the place at rest and six
/// constants. Operations: 24 of the axes, 18 of p, 33 of psi with the series of the arc sine, 24 of the series of c, 84 of
/// forces and torques, and 28 for each product of quaternions; of beams three of these and 146 of the energy's slope.
constexpr Work beam_work{2 * 32 + 8 + 8, 183 + 3 * 28 + 146}, joint_work{32 + 8 + 24 + 48, 183 + 2 * 28 + 12};

std::string joints() {
  std::string text;
  for (int i = 0; i + 1 < frames; ++i)
    text += fmt::format("BEGIN_SPRING {} {} KS_T 100 100 KS_R 1 1 REST_T 0.1 0 0 END_SPRING ", i, i + 1);
  return fmt::format(R"(<JointSpringForceField name="joints" spring="{}"/>)", text);
}

void time(benchmark::State& state, const Chain& chain, Figure& figure) {
  setThreads(1);
  Simulation& simulation = keptSimulation(chain.name, chain_steps_before, "benchmarks/chain.xml", {}, chain.parts);
  if (simulation.states().at(0)->nodes() != frames)
    return state.SkipWithError("the scene has another number of frames than the figure is made for");
  if (chain.implicit) {
    figure.work = (frame_work + chain.joint) * frames + factorWork(simulation);
    figure.working_set = figure.work.bytes;
  }
  for (auto _ : state)
    if (simulation.step().diverged) state.SkipWithError("the step diverged");
}

}  // namespace

void addFrameFigures(Catalogue& catalogue) {
  const std::string is_explicit = R"(<EulerExplicitSolver name="solver"/>)";
  const Replacement implicit{is_explicit, R"(<EulerImplicitSolver name="solver"/><SparseLDLSolver name="linear"/>)"};
  for (const Chain& chain :
       {Chain{"frames, explicit", {}, {{beams, ""}}}, Chain{"joints, explicit", joint_work, {{beams, joints()}}},
        Chain{"beams, explicit", beam_work, {}}, Chain{"beams, implicit", beam_work, {implicit}, true}}) {
    Figure figure;
    figure.name = "chain 1,000 " + chain.name;
    figure.unit = "ns/frame";
    figure.per_second = 1e9 / frames;
    if (!chain.implicit) figure.target = 50;
    figure.work = (frame_work + chain.joint) * frames;
    figure.working_set = figure.work.bytes;
    catalogue.add(figure, [chain, &catalogue](benchmark::State& state) {
      time(state, chain, catalogue.find("chain 1,000 " + chain.name)->figure);
    });
  }
}

}  // namespace stroma::bench
