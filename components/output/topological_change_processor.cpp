// SPDX-License-Identifier: LGPL-2.1-or-later
// TopologicalChangeProcessor: the changes of a mesh that a scene plans, by a file or by lists. Meshes do not change here: until
// the first change the scene runs as without it, and the step that would make it is refused.
//
// The file has a line "T= TIME" before the changes of an instant, such as "REMOVE Tetrahedron 1 0"; its first time counts, less
// `shift`. With useDataInputs the change is in the first step that starts after timeToRemove, where one of the lists names something.
//
// Source: names and attributes are SOFA's, which makes the changes at the start of steps.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <TetrahedronSetTopologyContainer position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
//   <TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>
//   <TopologicalChangeProcessor useDataInputs="true" timeToRemove="2" tetrahedraToRemove="0"/>
// </Node>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/scene/text.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/step_guard.h"

namespace stroma {
namespace {

class TopologicalChangeProcessor final : public Observer, public StepGuard {
 public:
  void declare(DataTable& table) override {
    table.add("filename", file_name_).help("file of the changes").input();
    table.add("interval", interval_).unit("s").min(0).help("SOFA's; without effect on the first change");
    table.add("shift", shift_).unit("s").help("time of the file less time of the scene");
    table.add("loop", loops_).help("SOFA's; without effect on the first change");
    table.add("useDataInputs", by_lists_).help("the lists below instead of the file");
    table.add("timeToRemove", time_).unit("s").help("when what they name is to be removed");
    table.add("pointsToRemove", points_).help("points to be removed");
    table.add("edgesToRemove", edges_).help("edges to be removed");
    table.add("trianglesToRemove", triangles_).help("triangles to be removed");
    table.add("quadsToRemove", quads_).help("quads to be removed");
    table.add("tetrahedraToRemove", tetrahedra_).help("tetrahedra to be removed");
    table.add("hexahedraToRemove", hexahedra_).help("hexahedra to be removed");
    for (const char* name : {"saveIndicesAtInit", "epsilonSnapPath", "epsilonSnapBorder", "draw", "listChanges", "topology"})
      table.addVisualOnly(name);
  }

  void init() override {
    first_ = std::numeric_limits<double>::infinity();
    bool names_some = false;
    for (const std::vector<int>* list : {&points_, &edges_, &triangles_, &quads_, &tetrahedra_, &hexahedra_})
      names_some = names_some || !list->empty();
    if (by_lists_ && names_some) first_ = time_;
    if (!by_lists_ && !file_name_.given.empty()) first_ = firstOfFile() - shift_;
    const double start = node().root().root_time;
    if (isDue(start, node().root().dt()))
      throw ComponentError(fmt::format("meshes do not change here, and the first change is due at t = {:g} s, {}", first_,
                                       first_ < start ? "before the run starts" : "where the run starts"),
                           "changes later on, or none");
    if (std::isfinite(first_))
      inform(fmt::format("meshes do not change here: the run ends at t = {:g} s, where the first change is due", first_));
  }

  void afterStep(const Simulation&, const StepContext&) override {}
  std::string describe() const override {
    if (!std::isfinite(first_)) return "waits for nothing";
    return fmt::format("ends the run at t = {:g} s, where a mesh would change", first_);
  }

  std::string refusal(const StepContext& context) override {
    if (!isDue(context.t, context.dt)) return {};
    return fmt::format("changes a mesh at t = {:g} s, which meshes here cannot, so the run ends here", first_);
  }

 private:
  /// At the start of a step.
  bool isDue(double t, double dt) const {
    constexpr double slack = 1e-6;  // of a step
    return by_lists_ ? t > first_ + slack * dt : t >= first_ - slack * dt;
  }
  /// The least time in the file; infinite where it plans nothing.
  double firstOfFile() const {
    std::ifstream stream(file_name_.found);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file_name_.given));
    const std::string& name = file_name_.given;
    if (name.ends_with(".gz")) throw ComponentError(fmt::format("the file {} is compressed", name), "the text in it");
    double first = std::numeric_limits<double>::infinity();
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
      std::istringstream words(line);
      std::string word, time_word;
      if (!(words >> word)) continue;
      if (word == "T=") {
        words >> time_word;
        char* end = nullptr;
        const double time = std::strtod(time_word.c_str(), &end);
        if (time_word.empty() || *end != '\0' || !std::isfinite(time))
          throw ComponentError(fmt::format("{}:{}: {} is no time", name, number, inQuotes(time_word)), "T= TIME");
        first = std::min(first, time);
      } else if (!std::isfinite(first)) {
        throw ComponentError(fmt::format("{}:{}: {} stands before any time", name, number, inQuotes(trimmed(line))), "T= TIME");
      }
    }
    return first;
  }

  FileName file_name_;
  bool loops_ = false, by_lists_ = false;
  double interval_ = 0, shift_ = 0, time_ = 0;
  std::vector<int> points_, edges_, triangles_, quads_, tetrahedra_, hexahedra_;
  double first_ = std::numeric_limits<double>::infinity();  ///< when the first change is due [s]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(topological_change_processor) {
  factory.add<stroma::TopologicalChangeProcessor>("TopologicalChangeProcessor", "ends a run where a mesh would change");
}
