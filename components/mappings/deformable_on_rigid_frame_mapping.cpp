// SPDX-License-Identifier: LGPL-2.1-or-later
// DeformableOnRigidFrameMapping: points that deform in the axes of a rigid frame: a body with small strains carried by a frame
// with large motion.
//
//   x_i = c + q y_i,   v_i = c' + omega x r_i + q y_i',   r_i = q y_i
//   force on y_i: q^T f_i;   on the frame: sum f_i, torque sum r_i x f_i
//   x_i'' has omega x (omega x r_i) + 2 omega x q y_i' besides J times accelerations
//
// with y_i the nodes of input1, in the axes of the frame, and c and q the centre and the orientation of the frame `index` of
// input2 (counted from the last one with indexFromEnd). A state without positions gets a node for each of input1.
//
// geometricStiffness: as the frame turns by dw, the force on y_i changes by q^T (f_i x dw), and the torque by (dw x r_i) x f_i +
// (q dy_i) x f_i. Exact has it in the tangent, without the part 1/2 [torque] as RigidMapping.
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <Node name="frame">
//     <MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0 0 0 1"/>
//     <UniformMass totalMass="2" inertia="0.01 0.02 0.03"/>
//   </Node>
//   <Node name="local">
//     <MechanicalObject name="dofs" position="0.1 0 0  -0.1 0 0.1"/>
//     <UniformMass totalMass="0.1"/>
//     <RestShapeSpringsForceField stiffness="100"/>
//     <Node name="space">
//       <MechanicalObject name="points"/>
//       <DeformableOnRigidFrameMapping input1="@../dofs" input2="@../../frame/dofs" output="@points"/>
//       <ConstantForceField indices="0" forces="0 0 1"/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/mappings/followed_nodes.h"
#include "components/mappings/linked_mapping.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DeformableOnRigidFrameMapping final : public CurvedMapping {
 public:
  void declare(DataTable& table) override {
    CurvedMapping::declare(table);
    table.find("input")->alias("input1");
    table.addLink("input2", frame_link_).help("state of the frame that carries the points");
    table.add("index", index_).help("which frame of input2").min(0);
    table.add("indexFromEnd", from_end_).help("count index from the last frame: 0 is the last");
    table.add("applyRestPosition", place_rest_).help("the rest positions of the child are also those that the frame gives");
    declareGeometricStiffness(table, geometric_, false);
  }

  void init() override {
    LinkedMapping::init();
    frame_ = frame_link_.get();
    State& child = output();
    if (!input().hasPointsOnly() || !child.hasPointsOnly())
      throw ComponentError(fmt::format("the nodes of {} are no points", (input().hasPointsOnly() ? child : input()).path()),
                           "input1 and output of template Vec3");
    if (!frame_ || !frame_->hasFrames() || index_ >= frame_->nodes())
      throw ComponentError(frame_ ? fmt::format("{} has no frame {}", frame_->path(), index_) : "input2 is not given",
                           "a frame of a state of template Rigid3");
    takeNodesOf(input(), allNodes(input()), child);
    if (child.nodes() != input().nodes())
      throw ComponentError(
          fmt::format("{} has {} nodes and {} has {}", child.path(), child.nodes(), input().path(), input().nodes()),
          "as many of each");
    arms_.assign(std::size_t(input().size()), Vec3::Zero());
    frame_number_ = from_end_ ? frame_->nodes() - 1 - index_ : index_;
    place(frame_->position, input().position, child.position);
    if (place_rest_) place(frame_->rest_position, input().rest_position, child.rest_position);
  }

  std::vector<State*> inputs() const override { return {&input(), frame_}; }

  void apply(Rows x) const override {
    axes_ = orientationIn(x, centreRow() + 1).toRotationMatrix();
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      arms_[i] = axes_ * x[local(i)];
      x[own(i)] = x[centreRow()] + arms_[i];
    }
  }
  void applyJ(Rows v) const override {
    const Vec3 linear = v[centreRow()], spin = v[centreRow() + 1];
    for (std::size_t i = 0; i < arms_.size(); ++i) v[own(i)] = linear + spin.cross(arms_[i]) + axes_ * v[local(i)];
  }
  void applyJT(Rows f) const override {
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      const Vec3 force = f[own(i)];
      f[local(i)] += axes_.transpose() * force;
      f[centreRow()] += force, f[centreRow() + 1] += arms_[i].cross(force);
    }
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      out.push_back({own(i), local(i), axes_});
      out.push_back({own(i), centreRow(), Mat3::Identity()});
      out.push_back({own(i), centreRow() + 1, -crossMatrix(arms_[i])});
    }
  }
  void addCurvature(ConstRows v, Rows a) const override {
    if (!convects()) return;
    const Vec3 spin = v[centreRow() + 1];
    for (std::size_t i = 0; i < arms_.size(); ++i)
      a[own(i)] += spin.cross(spin.cross(arms_[i])) + 2 * spin.cross(axes_ * v[local(i)]);
  }

 protected:
  void geometricBlocks(ConstRows f, std::vector<Block>& out) const override {
    if (geometric_ == GeometricStiffness::none) return;
    const Index turn = centreRow() + 1;
    for (Index i = 0; i < input().size(); ++i) {
      const Index y = input().firstRow() + i;
      Block of_force{y, turn, Mat3::Zero()}, of_torque{turn, y, Mat3::Zero()}, of_turn{turn, turn, Mat3::Zero()};
      if (f.count > 0) {
        const Vec3 force = f[output().firstRow() + i], &r = arms_[std::size_t(i)];
        of_force.value = axes_.transpose() * crossMatrix(force);
        of_torque.value = of_force.value.transpose();
        of_turn.value = 0.5 * (r * force.transpose() + force * r.transpose()) - r.dot(force) * Mat3::Identity();
      }
      for (const Block& block : {of_force, of_torque, of_turn}) out.push_back(block);
    }
  }

 private:
  Index centreRow() const { return frame_->firstRow() + 2 * frame_number_; }
  Index local(std::size_t i) const { return input().firstRow() + Index(i); }
  Index own(std::size_t i) const { return output().firstRow() + Index(i); }
  void place(const std::vector<Vec3>& frames, const std::vector<Vec3>& from, std::vector<Vec3>& to) const {
    const std::size_t row = 2 * std::size_t(frame_number_);
    const Quaternion turn = turnedBy(frames[row + 1]);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = frames[row] + turn * from[i];
  }

  Link<State> frame_link_{"mechanical state"};
  State* frame_ = nullptr;
  int index_ = 0;
  Index frame_number_ = 0;
  bool from_end_ = false, place_rest_ = true;
  GeometricStiffness geometric_ = GeometricStiffness::exact;
  mutable Mat3 axes_ = Mat3::Identity();  ///< of the frame, at the last apply()
  mutable std::vector<Vec3> arms_;        ///< r at the last apply() [m]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(deformable_on_rigid_frame_mapping) {
  factory.add<stroma::DeformableOnRigidFrameMapping>("DeformableOnRigidFrameMapping",
                                                     "points that deform in the axes of a rigid frame");
}
