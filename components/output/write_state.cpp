// SPDX-License-Identifier: LGPL-2.1-or-later
// WriteState: the positions of a state over time, in a text file.
//
// For every instant written, the file has a line `T= t` and, indented below it, `X= x0 y0 z0 x1 ...` [m] (of a rigid frame
// seven numbers, its centre and its quaternion x y z w, of a number one) and on request `X0=` (rest positions [m]), `V=`
// (velocities [m/s]) and `F=` (forces [N]). Numbers have the fewest digits that read back to the same bits. A name that ends
// in ".gz" gives a compressed file. Each frame is in the file, with a checksum, when its step ends: the file of a killed run
// can be read up to there. A run continued from a checkpoint keeps the frames up to there, if the file has the same name.
//
// Instants: `time` lists times to write; after the last of them, or from the start when there are none, one instant every
// `period`. With neither, every step. An instant is written by the first step that reaches it. Where SOFA acts before a step,
// so that the result of the last one is missing, this component acts at the start and after each step. F is the net force of
// all force fields and of gravity at the instant, which takes one evaluation more per step. At a constrained node it is the
// force exerted by the body: the reaction of the support has the opposite sign.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 0 0  0 2 0"/>
//   <UniformMass totalMass="2"/>
//   <WriteState filename="fall.state.gz" writeV="true" period="0.1"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/state_file.h"

namespace stroma {
namespace {

class WriteState final : public Observer {
 public:
  void declare(DataTable& table) override {
    table.addLink("mstate", mstate_).help("state to write; the one of this node by default");
    table.add("filename", file_name_).help("file to write; compressed when it ends in .gz").required();
    table.add("writeX", write_x_).help("write positions");
    table.add("writeX0", write_x0_).help("write rest positions");
    table.add("writeV", write_v_).help("write velocities");
    table.add("writeF", write_f_).help("write forces");
    table.add("time", times_).unit("s").help("times to write, ascending");
    table.add("period", period_)
        .unit("s")
        .min(0)
        .help(
            "time between writes after the last of `time`; 0: every step if `time` is empty, else none");
    table.add("DOFsX", nodes_x_).help("nodes whose positions are written; all when empty");
    table.add("DOFsV", nodes_v_).help("nodes whose velocities are written; all when empty");
  }

  void init() override {
    state_ = mstate_.get() ? mstate_.get() : find<State>();
    if (!state_) throw ComponentError("no state to write", "a MechanicalObject in this node, or mstate=\"@path\"");
    if (!write_x_ && !write_x0_ && !write_v_ && !write_f_)
      throw ComponentError("nothing to write", "one of writeX, writeX0, writeV, writeF true");
    if (write_f_) state_->requestForce();
    checkNodes("DOFsX", nodes_x_);
    checkNodes("DOFsV", nodes_v_);
    for (std::size_t i = 1; i < times_.size(); ++i)
      if (!(times_[i - 1] < times_[i])) throw ComponentError("the values of time are not ascending");
  }

  void compile(const Simulation&) override {
    if (!state_->isBound())
      throw ComponentError(fmt::format("no integrator moves the state {}", state_->path()),
                           "an integrator in the state's node or above");
  }
  void begin(const Simulation& simulation) override {
    writer_.emplace(file_name_.found);
    if (simulation.steps() > 0) {
      if (writer_->goOn(simulation.time(), true, state_) == simulation.time()) return;
    } else {
      start_ = simulation.time(), next_time_ = 0, periods_ = 0;
    }
    if (write_f_)
      for (const auto& system : simulation.systems()) system->computeForce(system->x, system->v, system->f);
    if (isDue(simulation.time(), simulation.dt())) write(simulation.time());
  }

  void afterStep(const Simulation&, const StepContext& context) override {
    if (isDue(context.t_end, context.dt)) write(context.t_end);
  }

  void end(const Simulation&) override {
    if (std::optional<StateWriter> writer = std::exchange(writer_, std::nullopt)) writer->close();
  }
  std::vector<std::string> files() const override { return {file_name_.found}; }

  void serialize(Archive& archive) override {
    archive.value("start", start_);
    archive.value("next_time", next_time_);
    archive.value("periods", periods_);
  }

  std::string describe() const override {
    std::string when = times_.empty() ? "" : fmt::format("at {} given times", times_.size());
    if (period_ > 0) when += fmt::format("{}every {:.6g} s", when.empty() ? "" : ", then ", period_);
    if (when.empty()) when = "every step";
    return fmt::format("writes {}{}{}{}of {} to {} {}", write_x_ ? "X " : "", write_x0_ ? "X0 " : "",
                       write_v_ ? "V " : "", write_f_ ? "F " : "", state_->path(), file_name_.given, when);
  }

 private:
  void checkNodes(const char* attribute, const std::vector<int>& nodes) const {
    for (std::size_t i = 0; i < nodes.size(); ++i) checkNode(nodes[i], i, *state_, attribute);
  }

  bool isDue(double t, double dt) {
    const double reached = t + 1e-6 * dt;  // a time that round-off put just after the step belongs to the step
    bool due = times_.empty() && period_ == 0;
    for (; next_time_ < times_.size() && times_[next_time_] <= reached; ++next_time_) due = true;
    if (period_ == 0 || next_time_ < times_.size()) return due;
    const double first = times_.empty() ? start_ : times_.back();
    if (first + double(periods_) * period_ > reached) return due;
    // steps may be far longer than the period: whole periods are not counted one by one, but for the last
    constexpr double most = 1e15;
    periods_ = std::max(periods_, long(std::min((reached - first) / period_, most)) - 1);
    while (first + double(periods_) * period_ <= reached && double(periods_) < most) ++periods_;
    return true;
  }

  void write(double t) {
    StateWriter& writer = writer_.value();
    writer.time(t);
    if (write_x0_) {
      Vector rest(state_->size());
      for (Index i = 0; i < state_->size(); ++i)
        placeRow(state_->kindOf(i), state_->rest_position[std::size_t(i)], rest, i);
      writer.rows("X0", *state_, rest);
    }
    if (write_x_) writer.rows("X", *state_, state_->x(), nodes_x_);
    if (write_v_) writer.rows("V", *state_, state_->v(), nodes_v_);
    if (write_f_) writer.rows("F", *state_, state_->f());
    writer.finish();
  }

  Link<State> mstate_{"mechanical state"};
  FileName file_name_;
  bool write_x_ = true, write_x0_ = false, write_v_ = false, write_f_ = false;
  std::vector<double> times_;
  double period_ = 0;
  std::vector<int> nodes_x_, nodes_v_;

  State* state_ = nullptr;
  std::optional<StateWriter> writer_;
  double start_ = 0;
  std::size_t next_time_ = 0;
  long periods_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(write_state) {
  factory.add<stroma::WriteState>("WriteState", "writes positions, velocities and forces of a state over time");
}
