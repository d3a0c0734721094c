// SPDX-License-Identifier: LGPL-2.1-or-later
// EnergyMonitor: the energies of the scene over time, in columns.
//
// Columns: time; kinetic energy 1/2 v^T M v; elastic energy (the sum over the force fields); gravity energy -sum m g.x; their
// total E; and the defect E(t) - E(0) of the energy balance, summed over every system of the scene. The first line has the
// units, if the scene declares them. The defect is the work removed (negative) or added (positive) by damping, the integration
// scheme and prescribed motion: it is zero for an exact scheme without damping, implicit Euler makes it negative, and
// unbounded growth indicates divergence. The second line of the file warns if a force field has no potential, because the
// defect then contains its work. The first row is the start, then one every `exportEveryNumberOfSteps` steps.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0"/>
//   <UniformMass totalMass="2"/>
//   <EnergyMonitor filename="energy.txt" exportEveryNumberOfSteps="5"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/output/table_file.h"
#include "framework/scene/factory.h"
#include "framework/scene/written_units.h"
#include "framework/simulation/energies.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/state_file.h"

namespace stroma {
namespace {

class EnergyMonitor final : public Observer {
 public:
  void declare(DataTable& table) override {
    table.add("filename", file_name_).help("text file to write").required();
    table.add("exportEveryNumberOfSteps", every_).min(1).help("steps between two lines");
  }

  void begin(const Simulation& simulation) override {
    const bool conservative =
        std::ranges::all_of(simulation.systems(), [](const auto& system) { return system->isConservative(); });
    const auto unit = [&simulation](const char* si_unit) { return unitInBrackets(simulation.scene(), si_unit); };
    const std::string head =
        fmt::format("# time{}, energies{}: kinetic elastic gravity total defect\n{}", unit("s"), unit("J"),
                    conservative ? "" : "# some force fields have no potential: the defect contains their work\n");
    if (file_.open(file_name_.found, simulation.steps() > 0, head))
      write(simulation, simulation.time(), simulation.steps() == 0);
  }
  void serialize(Archive& archive) override {
    file_.serialize(archive, "end_of_file");
    archive.value("total_at_start", total_at_start_);
  }

  void afterStep(const Simulation& simulation, const StepContext& context) override {
    if (context.index % every_ == 0) write(simulation, context.t_end, false);
  }

  std::vector<std::string> files() const override { return {file_name_.found}; }
  bool readsAllNodes(const StepContext& context) const override { return context.index % every_ == 0; }
  void end(const Simulation&) override { file_.close(); }

  std::string describe() const override {
    return fmt::format("evaluates the energies and writes them to {} every {} step{}", file_name_.given, every_,
                       every_ == 1 ? "" : "s");
  }

 private:
  void write(const Simulation& simulation, double t, bool first) {
    const auto [kinetic, elastic, gravity, total] = energiesOf(simulation.systems());
    if (first) total_at_start_ = total;
    line_.clear();
    appendNumber(line_, t);
    for (const double energy : {kinetic, elastic, gravity, total, total - total_at_start_})
      appendNumber(line_ += ' ', energy);
    line_ += '\n';
    file_.write(line_);
  }

  FileName file_name_;
  int every_ = 1;

  TableFile file_;
  double total_at_start_ = 0;
  std::string line_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(energy_monitor) {
  factory.add<stroma::EnergyMonitor>("EnergyMonitor", "writes kinetic, elastic, gravity and total energy over time");
}
