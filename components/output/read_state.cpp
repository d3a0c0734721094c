// SPDX-License-Identifier: LGPL-2.1-or-later
// ReadState: positions and velocities of a state from a file, as WriteState and `stroma run --record` write it.
//
// A frame of the file at T belongs to the time t = T - shift. Frames at or before the start of the run set the initial state:
// a file with one frame resumes a run. Each later frame is reached exactly at the end of a step; nothing is interpolated, and
// if a step reaches several, the last is used. During such a step the nodes move at the constant velocity that gets them
// there, and carry along what is attached to them. Between frames, and after the last, forces move the state; with a frame for
// every step this is a replay, and with the nodes fixed by a FixedProjectiveConstraint it stays at the last frame.
//
//   x = R(rotation) scalePos X + translation,   v = R(rotation) scalePos V
//
// with R the rotation about x, then y, then z. Without a line `V=` the velocity is that of the step which got there.
// `loop` starts the file again at its last time T_end: instants follow at T + T_end, T + 2 T_end and so on. `interval`
// lets instants in only every so many seconds from the start on.
//
// An unfinished recording, of a run that is still going or was killed, is read up to its last complete frame, with a warning.
//
// Where SOFA reads before a step, and resizes the state to what it finds, this component acts at the start and at the
// end of steps, and another number of nodes is an error. X0 and F of the file are not used.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 0 0  0 2 0"/>
//   <UniformMass totalMass="2"/>
//   <ReadState filename="meshes/fall.state"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "framework/mechanics/signs.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/simulation/state_file.h"

namespace stroma {
namespace {

class ReadState final : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("filename", file_name_).help("file to read, plain or compressed").input().required();
    table.add("interval", interval_).unit("s").min(0).help("least time between two readings; 0: every instant is read");
    table.add("shift", shift_).unit("s").help("time of the file less time of the scene");
    table.add("loop", loop_).help("start again at the end of the file");
    table.add("scalePos", scale_).unit("-").min(0, false).help("factor on positions and velocities");
    table.add("rotation", rotation_).unit("degree").help("turns positions, orientations and velocities about x, then y, then z");
    table.add("translation", translation_).unit("m").help("added to the positions, after scale and rotation");
  }

  void init() override {
    ProjectiveConstraint::init();
    try {
      StateRecording recording = readRecording(file_name_.found, &state());
      frames_ = std::move(recording.frames);
      if (!recording.unfinished.empty()) warn(recording.unfinished);
    } catch (const std::runtime_error& error) {
      throw ComponentError(error.what(), "a file that WriteState or `stroma run --record` wrote");
    }
    checkFrames();
    place();
    start_ = node().root().root_time;
    if (lastReached(start_) < 0)
      inform(fmt::format("the first instant of {} is at T = {:g} s: until then the state moves freely",
                         file_name_.given, frames_.front().time));
  }

  // ---- what is held, and when ----
  bool isConstant() const override { return false; }
  bool activeIn(double t, double t_end) const override {
    return ProjectiveConstraint::activeIn(t, t_end) && lastReached(t_end) > lastReached(t);
  }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    for (Index i = 0; i < state().size(); ++i) out.push_back({state().firstRow() + i, Mat3::Zero()});
  }
  bool prescribesMotion() const override { return loop_ || fileTime(start_) < frames_.back().time - slack_; }

  void placeStart(double t, Rows x, Rows v) const override {
    if (lastReached(t) >= 0) prescribe(t, x, v);
  }
  void prescribe(double t, Rows x, Rows v) const override {
    const long reached = lastReached(t);
    if (reached < 0) return;  // a stage of a step, before the first instant
    const StateFrame& frame = frames_[std::size_t(reached % long(frames_.size()))];
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i) {
      placeRow(state().kindOf(i), frame.x[std::size_t(i)], x, first + i);
      if (!frame.v.empty()) v[first + i] = frame.v[i];
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  void checkFrames() const {
    if (frames_.empty()) throw ComponentError(file_name_.found + ": the file holds no instant", "a line T= and more");
    const auto complain = [this](const StateFrame& frame, const std::string& what, const std::string& expected) {
      throw ComponentError(fmt::format("{}: at T = {:g} s there are {}", file_name_.found, frame.time, what), expected);
    };
    const std::size_t nodes = std::size_t(state().size());
    for (const StateFrame& frame : frames_) {
      if (frame.x.size() != nodes || (!frame.v.empty() && frame.v.size() != nodes))
        complain(frame, fmt::format("{} positions and {} velocities", frame.x.size(), frame.v.size()),
                 fmt::format("{} positions, as {} has nodes, and as many velocities or none", nodes, state().path()));
      const auto is_finite = [](const Vec3& value) { return value.allFinite(); };
      if (!std::isfinite(frame.time) || !std::ranges::all_of(frame.x, is_finite) ||
          !std::ranges::all_of(frame.v, is_finite))
        complain(frame, "numbers that are not finite", "the recording of a run that did not diverge");
    }
    for (std::size_t i = 1; i < frames_.size(); ++i)
      if (!(frames_[i].time > frames_[i - 1].time))
        complain(frames_[i], fmt::format("values after those at T = {:g} s", frames_[i - 1].time), "ascending times");
    if (loop_ && (frames_.size() < 2 || frames_.front().time < 0))
      throw ComponentError(fmt::format("{} cannot be repeated", file_name_.found),
                           "two instants or more, from T = 0 or later");
  }

  void place() {
    const Mat3 rotation = rotationFromDegrees(rotation_), turn = scale_ * rotation;
    const bool still = turn == Mat3::Identity() && translation_.isZero(0);  // then not a bit changes
    double gap = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < frames_.size(); ++i) gap = std::min(gap, frames_[i].time - frames_[i - 1].time);
    slack_ = 1e-6 * std::min(gap, std::max(1., std::abs(frames_.back().time)));
    if (still) return;
    if (!state().hasPointsOnly() && !state().hasFrames())
      throw ComponentError(state().path() + " has numbers, which are read as they are",
                           "no scalePos, rotation or translation");
    for (StateFrame& frame : frames_) {
      for (std::size_t i = 0; i < frame.x.size(); ++i)
        if (state().kindOf(Index(i)) == RowKind::turn)
          frame.x[i] = signedRotationVector(Quaternion(rotation) * turnedBy(frame.x[i]));
        else
          frame.x[i] = (turn * frame.x[i] + translation_).eval();
      for (std::size_t i = 0; i < frame.v.size(); ++i)
        frame.v[i] = ((state().kindOf(Index(i)) == RowKind::turn ? rotation : turn) * frame.v[i]).eval();
    }
  }

  double fileTime(double t) const { return t + shift_; }

  /// The number of the last instant at or before t [s], counted through all rounds of a loop; -1: none yet.
  long lastReached(double t) const {
    if (interval_ > 0) t = start_ + std::floor((t - start_) / interval_ + 1e-6) * interval_;
    double reached = fileTime(t) + slack_;
    long before = 0;
    if (loop_) {
      // the first instant of a round may come with the last of the one before, and then counts
      const double round = std::max(0., std::floor((reached - frames_.front().time) / frames_.back().time));
      before = long(round) * long(frames_.size());
      reached -= round * frames_.back().time;
    }
    const auto after = std::upper_bound(frames_.begin(), frames_.end(), reached,
                                        [](double time, const StateFrame& frame) { return time < frame.time; });
    return before + (after - frames_.begin()) - 1;
  }

  FileName file_name_;
  double interval_ = 0, shift_ = 0, scale_ = 1;
  bool loop_ = false;
  Vec3 rotation_ = Vec3::Zero(), translation_ = Vec3::Zero();

  std::vector<StateFrame> frames_;  ///< ascending in time, turned and moved
  double start_ = 0;                ///< of the run [s]
  double slack_ = 0;                ///< [s]: times closer than this are one
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(read_state) {
  factory.add<stroma::ReadState>("ReadState", "takes positions and velocities of a state from a file");
}
