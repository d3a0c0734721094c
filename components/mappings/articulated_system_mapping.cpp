// SPDX-License-Identifier: LGPL-2.1-or-later
// ArticulatedSystemMapping: rigid frames joined in a tree by hinges and sliders, as functions of their coordinates.
//
// The parent state has a number for each hinge (its angle [rad]) and each slider (its displacement [m]) (template Vec1). Frame
// 0 is the root: it is fixed at its start, or is the frame indexInput2 of input2. Each ArticulationCenter joins a frame
// `childIndex` to a frame `parentIndex` at a point that lies at posOnParent in the axes of the one and at posOnChild in those
// of the other; its Articulations follow one after the other,
//
//   q_child = q_parent exp(y_1 a_1) exp(y_2 a_2) ...,   c_child = c_parent + q_parent (posOnParent + sum of slides) - q_child posOnChild
//
// where a slider along a_k, which rotates with the hinges before it, adds y_k a_k to the sum. For a number y_k with the axis u
// in space, J has for every frame beyond it the velocities u x (c - joint) and u for a hinge, u and 0 for a slider.
//
// ArticulatedHierarchyContainer is in the node of the mapping or below; the centres are in nodes below it, and their
// articulations with them or in nodes below.
//
// Source: names and attributes are SOFA's; only articulationProcess 0 is supported.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-12"/>
//   <MechanicalObject name="angles" template="Vec1" position="0 0"/>
//   <UniformMass totalMass="0.01"/>
//   <RestShapeSpringsForceField stiffness="2"/>
//   <Node name="arm">
//     <MechanicalObject name="frames" template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1.5 0 0  0 0 0 1"/>
//     <ConstantForceField indices="1 2" forces="0 -1 0 0 0 0"/>
//     <ArticulatedSystemMapping input1="@../angles" output="@frames"/>
//     <ArticulatedHierarchyContainer/>
//     <Node name="shoulder">
//       <ArticulationCenter parentIndex="0" childIndex="1" posOnParent="0 0 0" posOnChild="-0.5 0 0"/>
//       <Articulation rotation="true" rotationAxis="0 0 1" articulationIndex="0"/>
//     </Node>
//     <Node name="elbow">
//       <ArticulationCenter parentIndex="1" childIndex="2" posOnParent="0.5 0 0" posOnChild="-0.5 0 0"/>
//       <Articulation rotation="true" rotationAxis="0 0 1" articulationIndex="1"/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/mappings/articulated_parts.h"
#include "components/mappings/linked_mapping.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ArticulatedSystemMapping final : public CurvedMapping {
 public:
  void declare(DataTable& table) override {
    CurvedMapping::declare(table);
    table.find("input")->alias("input1");
    table.addLink("input2", input2_)
        .help("state with the frame of the root; without it the root is fixed");
    table.add("indexInput2", root_index_).help("that frame").min(0);
    declareGeometricStiffness(table, geometric_, false);
    for (const char* name : {"container", "indexFromEnd"}) table.addVisualOnly(name);
  }
  void init() override;
  std::vector<State*> inputs() const override {
    std::vector<State*> states{&input()};
    if (root_) states.push_back(root_);
    return states;
  }
  void apply(Rows x) const override;
  void applyJ(Rows v) const override;
  void applyJT(Rows f) const override;
  void addJacobian(std::vector<JacobianBlock>& out) const override;
  void addCurvature(ConstRows v, Rows a) const override;

 protected:
  void geometricBlocks(ConstRows f, std::vector<Block>& out) const override;

 private:
  /// A hinge or a slide, and where it is at the last apply().
  struct Joint {
    bool is_hinge = true;
    Vec3 axis;
    Index number = 0;
  };
  struct Limb {
    Index parent = 0, child = 0;
    Vec3 on_parent, on_child;
    std::size_t first = 0, last = 0;  ///< of its joints
  };
  void collect();
  void order(std::vector<Limb> limbs);
  Index row(Index frame) const { return output().firstRow() + 2 * frame; }
  Index rowOf(const Joint& joint) const { return input().firstRow() + joint.number; }
  /// Velocity of the centre of a frame by a joint before it.
  Vec3 way(std::size_t joint, const Vec3& centre) const {
    return joints_[joint].is_hinge ? Vec3(axes_[joint].cross(centre - places_[joint])) : axes_[joint];
  }

  Link<State> input2_{"mechanical state"};
  int root_index_ = 0;
  GeometricStiffness geometric_ = GeometricStiffness::exact;
  State* root_ = nullptr;
  std::vector<Joint> joints_;
  std::vector<Limb> limbs_;                                    ///< parents before children
  std::vector<std::vector<std::size_t>> paths_;                ///< of each frame its joints, from the root on
  Vec3 root_centre_ = Vec3::Zero(), root_arm_ = Vec3::Zero();  ///< where it starts; in the axes of input2's frame
  Quaternion root_turn_ = Quaternion::Identity();              ///< the same of its orientation
  mutable std::vector<Vec3> axes_, places_, slides_;           ///< in space, of each joint; y a of slides, else zero
  struct Twin {
    Vec3 linear, angular;  ///< force and torque about the centre of a frame, or accelerations
  };
  mutable std::vector<Twin> of_frames_;  ///< work space
  mutable std::vector<Vec3> centres_;                          ///< of each frame
  mutable Vec3 pivot_ = Vec3::Zero();                          ///< the centre of input2's frame
};

void ArticulatedSystemMapping::init() {
  CurvedMapping::init();
  root_ = input2_.get();
  if (input().rows_per_node != 1 || input().kindOf(0) != RowKind::value)
    throw ComponentError(input().path() + " has no numbers", "a state of template Vec1");
  if (!output().hasFrames()) throw ComponentError(output().path() + " has no frames", "a state of template Rigid3");
  if (root_ && (!root_->hasFrames() || root_index_ >= root_->nodes()))
    throw ComponentError(fmt::format("{} has no frame {}", root_->path(), root_index_),
                         "a frame of a state of template Rigid3");
  collect();
  root_centre_ = output().position[0], root_turn_ = turnedBy(output().position[1]);
  if (root_) {
    const std::size_t at = std::size_t(2 * root_index_);
    const Quaternion back = turnedBy(root_->position[at + 1]).conjugate();
    root_arm_ = back * (root_centre_ - root_->position[at]), root_turn_ = back * root_turn_;
  }
}

/// That of its own node, or of the nearest above that has one.
const ArticulationCenter* centerOf(const Articulation& one, const std::vector<ArticulationCenter*>& centers) {
  for (const Node* at = &one.node(); at; at = at->parent())
    for (const ArticulationCenter* center : centers)
      if (&center->node() == at) return center;
  throw ComponentError(one.path() + " is in no ArticulationCenter's node", "one in its node or above it");
}

void ArticulatedSystemMapping::collect() {
  std::vector<ArticulationCenter*> centers;
  std::vector<Articulation*> articulations;
  node().collect(centers), node().collect(articulations);
  if (centers.empty())
    throw ComponentError("there is no ArticulationCenter in this node or below", "one for each joint");
  joints_.clear();
  std::vector<Limb> limbs;
  for (ArticulationCenter* center : centers) {
    center->ensureReady();
    for (const int frame : {center->parent, center->child})
      if (frame >= output().nodes())
        throw ComponentError(fmt::format("{} names frame {} of {}", center->path(), frame, output().nodes()),
                             fmt::format("0 to {}", output().nodes() - 1));
    Limb limb{Index(center->parent), Index(center->child), center->on_parent, center->on_child, joints_.size(), 0};
    for (Articulation* one : articulations) {
      if (centerOf(*one, centers) != center) continue;
      one->ensureReady();
      if (one->number >= input().nodes())
        throw ComponentError(fmt::format("{} names number {} of {}", one->path(), one->number, input().nodes()),
                             fmt::format("0 to {}", input().nodes() - 1));
      joints_.push_back({one->rotation, one->axis, Index(one->number)});
    }
    limb.last = joints_.size();
    limbs.push_back(limb);
  }
  order(std::move(limbs));
}

void ArticulatedSystemMapping::order(std::vector<Limb> limbs) {
  limbs_.clear();
  paths_.assign(std::size_t(output().nodes()), {});
  std::vector<char> placed(std::size_t(output().nodes()), 0);
  placed[0] = 1;
  while (!limbs.empty()) {
    const auto next =
        std::find_if(limbs.begin(), limbs.end(), [&](const Limb& limb) { return placed[std::size_t(limb.parent)]; });
    if (next == limbs.end() || placed[std::size_t(next->child)])
      throw ComponentError(next == limbs.end()
                               ? fmt::format("frame {} is not connected to frame 0", limbs[0].parent)
                               : fmt::format("two articulations place frame {}", next->child),
                           "a tree of frames from frame 0 on");
    placed[std::size_t(next->child)] = 1;
    std::vector<std::size_t>& path = paths_[std::size_t(next->child)] = paths_[std::size_t(next->parent)];
    for (std::size_t j = next->first; j < next->last; ++j) path.push_back(j);
    limbs_.push_back(*next);
    limbs.erase(next);
  }
  const auto lost = std::find(placed.begin(), placed.end(), 0);
  if (lost != placed.end())
    throw ComponentError(fmt::format("frame {} has no joint", lost - placed.begin()),
                         "an ArticulationCenter for each frame but 0");
  axes_.assign(joints_.size(), Vec3::Zero()), places_ = slides_ = axes_;
  centres_.assign(std::size_t(output().nodes()), Vec3::Zero());
  of_frames_.resize(centres_.size());
}

void ArticulatedSystemMapping::apply(Rows x) const {
  if (root_) {
    const Index at = root_->firstRow() + 2 * root_index_;
    const Quaternion q = orientationIn(x, at + 1);
    pivot_ = x[at];
    x[row(0)] = pivot_ + q * root_arm_;
    putOrientation(q * root_turn_, x, row(0) + 1);
  } else {
    x[row(0)] = root_centre_;
    putOrientation(root_turn_, x, row(0) + 1);
  }
  centres_[0] = x[row(0)];
  for (const Limb& limb : limbs_) {
    const Quaternion parent = orientationIn(x, row(limb.parent) + 1);
    Quaternion q = parent;
    Vec3 place = x[row(limb.parent)] + parent * limb.on_parent;
    for (std::size_t j = limb.first; j < limb.last; ++j) {
      const double y = x[rowOf(joints_[j])][0];
      axes_[j] = q * joints_[j].axis, places_[j] = place;
      if (joints_[j].is_hinge)
        q = q * turnedBy(y * joints_[j].axis);
      else
        place += slides_[j] = y * axes_[j];
    }
    x[row(limb.child)] = place - q * limb.on_child;
    putOrientation(q, x, row(limb.child) + 1);
    centres_[std::size_t(limb.child)] = x[row(limb.child)];
  }
}

// A limb moves with its parent, and by its own joints.
void ArticulatedSystemMapping::applyJ(Rows v) const {
  v[row(0)].setZero(), v[row(0) + 1].setZero();
  if (root_) {
    const Index at = root_->firstRow() + 2 * root_index_;
    v[row(0) + 1] = Vec3(v[at + 1]);
    v[row(0)] = v[at] + Vec3(v[at + 1]).cross(centres_[0] - pivot_);
  }
  for (const Limb& limb : limbs_) {
    const Vec3 &centre = centres_[std::size_t(limb.child)], arm = centre - centres_[std::size_t(limb.parent)];
    Vec3 angular = v[row(limb.parent) + 1], linear = v[row(limb.parent)] + angular.cross(arm);
    for (std::size_t j = limb.first; j < limb.last; ++j) {
      const double rate = v[rowOf(joints_[j])][0];
      linear += rate * way(j, centre);
      if (joints_[j].is_hinge) angular += rate * axes_[j];
    }
    v[row(limb.child)] = linear, v[row(limb.child) + 1] = angular;
  }
}

// From the ends to the root: a joint bears what acts on all frames beyond it.
void ArticulatedSystemMapping::applyJT(Rows f) const {
  for (Index frame = 0; frame < output().nodes(); ++frame)
    of_frames_[std::size_t(frame)] = {f[row(frame)], f[row(frame) + 1]};
  for (auto limb = limbs_.rbegin(); limb != limbs_.rend(); ++limb) {
    const Vec3& centre = centres_[std::size_t(limb->child)];
    const Twin& on_child = of_frames_[std::size_t(limb->child)];
    Twin& on_parent = of_frames_[std::size_t(limb->parent)];
    for (std::size_t j = limb->first; j < limb->last; ++j)
      f[rowOf(joints_[j])][0] +=
          way(j, centre).dot(on_child.linear) + (joints_[j].is_hinge ? axes_[j].dot(on_child.angular) : 0);
    on_parent.linear += on_child.linear;
    on_parent.angular += on_child.angular + (centre - centres_[std::size_t(limb->parent)]).cross(on_child.linear);
  }
  if (!root_) return;
  const Index at = root_->firstRow() + 2 * root_index_;
  f[at] += of_frames_[0].linear;
  f[at + 1] += of_frames_[0].angular + (centres_[0] - pivot_).cross(of_frames_[0].linear);
}

/// Of each frame the accelerations (of its centre; of its turn) where all y'' are zero: a point that moves with a body of
/// spin w and angular acceleration b at r from another has b x r + w x (w x r) more than that; a hinge adds y' u to the spin
/// and w x y' u to b, a slide 2 w x y' u.
void ArticulatedSystemMapping::addCurvature(ConstRows v, Rows a) const {
  if (!convects()) return;
  const auto carry = [](Vec3& linear, const Vec3& angular, const Vec3& spin, const Vec3& r) {
    linear += angular.cross(r) + spin.cross(spin.cross(r));
  };
  for (Twin& zero : of_frames_) zero = {Vec3::Zero(), Vec3::Zero()};
  if (root_) carry(of_frames_[0].linear, Vec3::Zero(), v[root_->firstRow() + 2 * root_index_ + 1], centres_[0] - pivot_);
  for (const Limb& limb : limbs_) {
    Vec3 linear = of_frames_[std::size_t(limb.parent)].linear, angular = of_frames_[std::size_t(limb.parent)].angular;
    Vec3 spin = v[row(limb.parent) + 1], at = centres_[std::size_t(limb.parent)];
    const auto carryTo = [&](const Vec3& place) { carry(linear, angular, spin, place - at), at = place; };
    for (std::size_t j = limb.first; j < limb.last; ++j) {
      const Vec3 rate = v[rowOf(joints_[j])][0] * axes_[j];
      carryTo(places_[j]);
      if (joints_[j].is_hinge) {
        angular += spin.cross(rate), spin += rate;
      } else {
        linear += 2 * spin.cross(rate);
        carryTo(places_[j] + slides_[j]);
      }
    }
    carryTo(centres_[std::size_t(limb.child)]);
    of_frames_[std::size_t(limb.child)] = {linear, angular};
  }
  for (Index frame = 0; frame < output().nodes(); ++frame)
    a[row(frame)] += of_frames_[std::size_t(frame)].linear, a[row(frame) + 1] += of_frames_[std::size_t(frame)].angular;
}

void ArticulatedSystemMapping::addJacobian(std::vector<JacobianBlock>& out) const {
  for (Index frame = 0; frame < output().nodes(); ++frame) {
    const Vec3& centre = centres_[std::size_t(frame)];
    const Index own = row(frame);
    if (root_) {
      const Index at = root_->firstRow() + 2 * root_index_;
      out.push_back({own, at, Mat3::Identity()});
      out.push_back({own, at + 1, -crossMatrix(centre - pivot_)});
      out.push_back({own + 1, at + 1, Mat3::Identity()});
    }
    for (const std::size_t j : paths_[std::size_t(frame)]) {
      out.push_back({own, rowOf(joints_[j]), way(j, centre) * Vec3::UnitX().transpose()});
      const Vec3 turn = joints_[j].is_hinge ? axes_[j] : Vec3(Vec3::Zero());
      out.push_back({own + 1, rowOf(joints_[j]), turn * Vec3::UnitX().transpose()});
    }
  }
}

/// d2c/dy_i dy_j = u_i x (dc/dy_j) for a hinge i before j or j itself; of the turn, 1/2 u_i x u_j.
void ArticulatedSystemMapping::geometricBlocks(ConstRows f, std::vector<Block>& out) const {
  if (geometric_ == GeometricStiffness::none) return;
  const Mat3 first = Vec3::UnitX() * Vec3::UnitX().transpose();
  for (Index frame = 0; frame < output().nodes(); ++frame) {
    const Vec3& centre = centres_[std::size_t(frame)];
    const Vec3 force = f.count > 0 ? Vec3(f[row(frame)]) : Vec3(Vec3::Zero());
    const Vec3 torque = f.count > 0 ? Vec3(f[row(frame) + 1]) : Vec3(Vec3::Zero());
    const std::vector<std::size_t>& path = paths_[std::size_t(frame)];
    for (std::size_t b = 0; b < path.size(); ++b) {
      const std::size_t j = path[b];
      const Vec3 linear = way(j, centre), turn = joints_[j].is_hinge ? axes_[j] : Vec3(Vec3::Zero());
      const Vec3 moment = linear.cross(force) + 0.5 * turn.cross(torque);  // a turn th before j works th.moment
      if (root_) {
        const Index at = root_->firstRow() + 2 * root_index_ + 1;
        out.push_back({at, rowOf(joints_[j]), moment * Vec3::UnitX().transpose()});
        out.push_back({rowOf(joints_[j]), at, Vec3::UnitX() * moment.transpose()});
      }
      for (std::size_t a = 0; a <= b; ++a) {
        const std::size_t i = path[a];
        const double value = joints_[i].is_hinge ? axes_[i].dot(moment) : 0;
        out.push_back({rowOf(joints_[i]), rowOf(joints_[j]), value * first});
        if (a != b) out.push_back({rowOf(joints_[j]), rowOf(joints_[i]), value * first});
      }
    }
    if (!root_) continue;
    const Index at = root_->firstRow() + 2 * root_index_ + 1;
    const Vec3 r = centre - pivot_;
    out.push_back({at, at, 0.5 * (r * force.transpose() + force * r.transpose()) - r.dot(force) * Mat3::Identity()});
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(articulated_system_mapping) {
  factory.add<stroma::ArticulatedSystemMapping>("ArticulatedSystemMapping",
                                                "frames joined in a tree by hinges and slides");
  factory.add<stroma::ArticulatedHierarchyContainer>("ArticulatedHierarchyContainer",
                                                     "the articulated system of a node");
  factory.add<stroma::ArticulationCenter>("ArticulationCenter", "a joint between two frames of an articulated system");
  factory.add<stroma::Articulation>("Articulation", "a hinge or a slide of a joint");
}
