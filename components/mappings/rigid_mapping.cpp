// SPDX-License-Identifier: LGPL-2.1-or-later
// RigidMapping: points, or frames, attached to rigid frames.
//
//   x_i = c + q p_i,   v_i = c' + omega x (q p_i);   force on the frame: sum f_i, torque sum (q p_i) x f_i
//
// with c and q the centre and the orientation of the frame `index` of the parent state (counted from the last one with
// indexFromEnd), or of the frame that rigidIndexPerPoint lists for each point, or repartition by the number of points in a
// row. p_i, the position of the point in the axes of its frame, is initialPoints, or the position of the child as the scene
// gives it, or with useX0 its rest position. With globalToLocalCoords these are positions in space at the start (useX0: at
// rest). A child without positions has as many points as initialPoints.
//
// A child of frames (template Rigid3) is carried in the same way, each at p_i and rotated by the orientation that the scene
// gives; RigidRigidMapping is another name for this, with initialPoints that are frames: x y z and a quaternion x y z w.
//
// geometricStiffness: the torque of f_i changes as the frame rotates, by (dw x r) x f. Exact has it in the tangent, without
// the part 1/2 [torque], which vanishes for the sum of torques on a frame in equilibrium: the tangent is then symmetric.
// Stabilized has only the stabilising part of it: for each frame that with restoring eigenvalues.
//
// Source: the names and attributes are SOFA's, whose Exact is not symmetric.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject name="body" template="Rigid3" position="0 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.01 0.02 0.03"/>
//   <Node name="corners">
//     <MechanicalObject name="points" position="0.1 0 0  -0.1 0 0.1"/>
//     <RigidMapping/>
//     <RestShapeSpringsForceField points="0" stiffness="100"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/mappings/followed_nodes.h"
#include "components/mappings/frame_mapping.h"
#include "framework/mechanics/state_positions.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RigidMapping : public FrameMapping {
 public:
  explicit RigidMapping(bool of_frames = false) : of_frames_(of_frames) {}

  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.add("index", index_).help("frame that carries all points").min(0);
    table.add("indexFromEnd", from_end_).help("count index from the last frame: 0 is the last");
    table.add("rigidIndexPerPoint", index_per_point_).help("frame that carries each point");
    table.add("mayMiscount", may_miscount_)
        .help("rigidIndexPerPoint with another number of values than points is ignored with a warning, as in SOFA");
    table.add("repartition", shares_).help("how many points each frame carries, in their order; one number: each as many");
    if (of_frames_)
      table.add("initialPoints", initial_frames_)
          .unit("-")
          .inValuesOf(7)
          .help("x y z and x y z w of each frame in the axes of its parent frame; the positions of the child by default");
    else
      table.add("initialPoints", initial_points_)
          .unit("m")
          .help("places of the points in the axes of their frames; the positions of the child by default");
    table.add("globalToLocalCoords", from_space_).help("the positions of the child are places in space at the start");
    table.add("useX0", use_rest_).help("the rest positions of the child in place of its positions");
    table.add("resizes", resizes_).help("a child of another number of nodes gets as many as initialPoints has, as in SOFA");
    table.add("applyRestPosition", place_rest_)
        .help("the rest positions of the child are also those that the frames give");
  }

  void init() override {
    FrameMapping::init();
    start();
    State& child = output();
    if (!child.hasPointsOnly() && !child.hasFrames())
      throw ComponentError(child.path() + " has numbers, which no frame carries", "points or frames");
    const bool listed = data().find("initialPoints")->isSet() && !(initial_points_.empty() && initial_frames_.empty());
    if (listed && use_rest_)
      throw ComponentError("initialPoints and useX0 are both given", "one of them: both say where the points are");
    if (listed) sizeChild(child);
    const std::vector<Vec3> given = use_rest_ ? child.rest_position : child.position;
    const std::vector<Vec3> places = listed ? listedPlaces() : nodePlaces(child, given);
    if (Index(places.size()) != child.nodes())
      throw ComponentError(
          fmt::format("initialPoints has {} points, and {} has {} nodes", places.size(), child.path(), child.nodes()),
          "as many of each");
    const std::vector<Index> frames = framesOf(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      Vec3 local = places[i];
      Quaternion turn = !child.hasFrames() ? Quaternion::Identity() : listed && of_frames_ ? listedTurn(i) : turnedBy(given[2 * i + 1]);
      if (from_space_) {
        const Quaternion back = orientation(frames[i], use_rest_).conjugate();
        local = back * (local - centre(frames[i], use_rest_)), turn = back * turn;
      }
      if (child.hasFrames())
        addFrame(frames[i], local, turn);
      else
        addPoint({{frames[i], 1, local}});
    }
    placeChild(place_rest_);
  }

 private:
  std::vector<Vec3> listedPlaces() const {
    if (!of_frames_) return initial_points_;
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < initial_frames_.size(); i += 7) places.emplace_back(&initial_frames_[i]);
    return places;
  }

  Quaternion listedTurn(std::size_t frame) const {
    const Quaternion q(&initial_frames_[7 * frame + 3]);
    if (!(std::abs(q.norm() - 1) < 1e-3))
      throw ComponentError(fmt::format("initialPoints: the quaternion of frame {} has the length {:.4g}", frame, q.norm()),
                           "x y z w of length one", "0 0 0 1 does not turn");
    return q.normalized();
  }

  /// A child of which the scene says neither places nor how many nodes it has gets as many as initialPoints has.
  void sizeChild(State& child) const {
    if (initial_frames_.size() % 7 != 0)
      throw ComponentError(fmt::format("initialPoints has {} numbers", initial_frames_.size()), "seven for each frame: x y z and x y z w");
    for (const char* name : {"position", "rest_position", "size"})
      if (const Data* data = child.data().find(name); !resizes_ && data && data->isSet()) return;
    if (!resizes_ && hasNodesOfMesh(child)) return;
    const std::size_t nodes = of_frames_ ? initial_frames_.size() / 7 : initial_points_.size();
    if (child.nodes() == Index(nodes)) return;
    const std::size_t rows = nodes * std::size_t(child.rows_per_node);
    const std::vector<RowKind> kinds = child.row_kinds;
    for (auto* vectors : {&child.position, &child.rest_position, &child.velocity}) vectors->assign(rows, Vec3::Zero());
    if (!kinds.empty()) child.row_kinds.clear();
    for (std::size_t i = 0; !kinds.empty() && i < rows; ++i) child.row_kinds.push_back(kinds[i % std::size_t(child.rows_per_node)]);
  }

  std::vector<Index> framesOf(std::size_t points) const {
    const Index count = input().nodes();
    std::vector<Index> frames(points, from_end_ ? count - 1 - index_ : index_);
    if (!shares_.empty()) {
      if (!index_per_point_.empty()) throw ComponentError("repartition and rigidIndexPerPoint are both given", "one of them");
      const std::vector<int> shares = shares_.size() == 1 ? std::vector<int>(std::size_t(count), shares_[0]) : shares_;
      if (Index(shares.size()) != count)
        throw ComponentError(fmt::format("repartition has {} numbers, and {} has {} frames", shares.size(), input().path(), count),
                             "one for each, or one for all");
      frames.clear();
      for (Index frame = 0; frame < count; ++frame)
        frames.insert(frames.end(), std::size_t(std::max(0, shares[std::size_t(frame)])), frame);
      if (frames.size() != points)
        throw ComponentError(fmt::format("repartition shares out {} points, and there are {}", frames.size(), points), "as many");
    } else if (!index_per_point_.empty()) {
      const bool fits = index_per_point_.size() == points;
      const std::string problem = fmt::format("rigidIndexPerPoint has {} values for {} points", index_per_point_.size(), points);
      if (!fits && !may_miscount_) throw ComponentError(problem, "one for each");
      if (!fits)
        warn(problem + fmt::format(": it is ignored, as in SOFA, and frame {} carries all points", frames[0]), "one for each");
      else
        frames.assign(index_per_point_.begin(), index_per_point_.end());
    }
    for (const Index frame : frames)
      if (frame < 0 || frame >= count)
        throw ComponentError(fmt::format("there is no frame {}: {} has {}", frame, input().path(), count),
                             fmt::format("0 to {}", count - 1));
    return frames;
  }

  const bool of_frames_;  ///< the places are frames, as SOFA's RigidRigidMapping has them
  int index_ = 0;
  bool from_end_ = false, from_space_ = false, use_rest_ = false, place_rest_ = true, resizes_ = false, may_miscount_ = false;
  std::vector<int> index_per_point_, shares_;
  std::vector<Vec3> initial_points_;
  std::vector<double> initial_frames_;
};

class RigidRigidMapping final : public RigidMapping {
 public:
  RigidRigidMapping() : RigidMapping(true) {}
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rigid_mapping) {
  factory.add<stroma::RigidMapping>("RigidMapping", "points or frames fixed in rigid frames");
  factory.add<stroma::RigidRigidMapping>("RigidRigidMapping", "frames fixed in rigid frames");
}
