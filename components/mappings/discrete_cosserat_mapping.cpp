// SPDX-License-Identifier: LGPL-2.1-or-later
// DiscreteCosseratMapping: frames on a rod of sections with constant strains, such as a catheter, a tendon or an arm.
//
// The rod starts in the frame baseIndex of input2, along its x axis. Section i is between the lengths curv_abs_input[i] and
// curv_abs_input[i + 1] of the rod. Node i of input1 (Vec3) is its curvature in its own axes: torsion k_x, bending k_y and k_z
// [rad/m]. With template Vec6 it has three more numbers e: the stretch of the rod along its axis, and its shear along y and z.
// The output has a frame at each length curv_abs_output. From the start (p, R) of a section, at l into it,
//
//   R(l) = R exp [l k],   p(l) = p + R integral of exp [s k] a ds from 0 to l,   a = (1, 0, 0) + e
//
// A change k' rotates the rod beyond the section with R V l k' and moves its end by R d' (bent_piece.h), e' moves it by R l V
// e': these are the columns of J. The derivative of J with respect to the shape, the geometric stiffness, is left out, as in
// the plugin.
//
// Source: name, attributes and law are those of the plug-in Cosserat for SOFA (Adagolodjo, Renda, Duriez: Coupling numerical
// deformable models in global and reduced coordinates for the simulation of the direct and the inverse kinematics of soft robots,
// IEEE Robotics and Automation Letters 6, 2021).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver rayleighStiffness="0.1"/>
//   <SparseLDLSolver/>
//   <Node name="base">
//     <MechanicalObject name="frame" template="Rigid3" position="0 0 0 0 0 0 1"/>
//     <UniformMass totalMass="0.01"/>
//     <FixedProjectiveConstraint indices="0"/>
//   </Node>
//   <Node name="strains">
//     <MechanicalObject name="curvature" position="0 0 0  0 0 0"/>
//     <UniformMass totalMass="1e-6"/>
//     <BeamHookeLawForceField length="0.1 0.1" radius="0.005" youngModulus="1e6" poissonRatio="0.4"/>
//     <Node name="rod">
//       <MechanicalObject name="frames" template="Rigid3" position="0 0 0 0 0 0 1  0.1 0 0 0 0 0 1  0.2 0 0 0 0 0 1"/>
//       <UniformMass totalMass="0.02" inertia="1e-6 1e-6 1e-6"/>
//       <DiscreteCosseratMapping input1="@../curvature" input2="@../../base/frame" output="@frames" curv_abs_input="0 0.1 0.2"
//         curv_abs_output="0 0.1 0.2"/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/mappings/bent_piece.h"
#include "components/mappings/linked_mapping.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DiscreteCosseratMapping final : public LinkedMapping {
 public:
  void declare(DataTable& table) override {
    LinkedMapping::declare(table);
    declareConvection(table, convects_);
    table.find("input")->alias("input1");
    table.addLink("input2", base_link_).help("state of the frame in which the rod starts");
    table.add("baseIndex", base_index_).help("that frame").min(0);
    table.add("curv_abs_input", section_ends_)
        .unit("m")
        .help("lengths of the rod where sections begin and end, from its start on")
        .required();
    table.add("curv_abs_output", frame_places_).unit("m").help("lengths of the rod where its frames are").required();
    for (const char* name : {"debug", "deformationAxis", "max", "min", "radius", "drawMapBeam", "color", "index"})
      table.addVisualOnly(name);
  }
  void init() override;
  std::vector<State*> inputs() const override { return {&input(), base_}; }
  bool isLinear() const override { return false; }
  void apply(Rows x) const override;
  void applyJ(Rows v) const override;
  void applyJT(Rows f) const override;
  void addJacobian(std::vector<JacobianBlock>& out) const override;
  void addCurvature(ConstRows v, Rows a) const override;
  void addGeometricProduct(ConstRows, ConstRows, double, Rows) const override {}
  void addGeometricPattern(BlockPattern&) const override {}
  void addGeometricStiffness(ConstRows, double, BlockMatrix&) const override {}

 private:
  bool convects_ = true;
  /// A section from its start to its end, or to a frame in it; at the last apply().
  struct Span {
    std::size_t section = 0;
    double length = 0;
    BentPiece piece;
    Quaternion turn = Quaternion::Identity();            ///< at its start
    Mat3 axes = Mat3::Identity();                        ///< the same as a matrix
    Vec3 end = Vec3::Zero();                             ///< where its end is
    Mat3 turning = Mat3::Zero(), moving = Mat3::Zero();  ///< turn, for e way, and way of its end for k
  };
  /// A motion of a place of the rod, its acceleration, or a load there.
  struct Twin {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  };
  void checkStates();
  void findFrames();
  /// The strains of a section in rows of x, of velocities or of forces.
  struct Strains {
    Vec3 curvature = Vec3::Zero(), stretch = Vec3::Zero();
  };
  Strains strainsIn(ConstRows rows, std::size_t section) const;
  void addTo(Rows rows, std::size_t section, const Strains& strains) const;
  void bend(Span& span, const Vec3& start, const Mat3& axes, const Strains& strains) const;
  void addColumns(std::size_t frame, const Span& span, std::vector<JacobianBlock>& out) const;
  /// visit(span) for the whole sections before a frame, and for its own up to it.
  template <class Visit>
  void alongTo(const Span& frame, Visit&& visit) const {
    for (std::size_t i = 0; i < frame.section; ++i) visit(sections_[i]);
    visit(frame);
  }
  bool stretches() const { return input().rows_per_node == 6; }
  Index rowOf(std::size_t section) const { return input().firstRow() + Index(section) * input().rows_per_node; }
  Index baseRow() const { return base_->firstRow() + 2 * base_index_; }
  Index row(std::size_t frame) const { return output().firstRow() + 2 * Index(frame); }
  /// The motion at the end of a span from that at its start, for a change of the strains.
  Twin carried(const Twin& start, const Span& span, const Strains& change) const {
    const Vec3 arm = span.axes * span.piece.way();
    Twin end{start.linear + start.angular.cross(arm) + span.moving * change.curvature,
             start.angular + span.turning * change.curvature};
    if (stretches()) end.linear += span.turning * change.stretch;
    return end;
  }

  Link<State> base_link_{"mechanical state"};
  State* base_ = nullptr;
  int base_index_ = 0;
  std::vector<double> section_ends_, frame_places_;
  mutable std::vector<Span> sections_, frames_;
  mutable std::vector<Twin> starts_;  ///< motions or loads where sections begin
  mutable Vec3 pivot_ = Vec3::Zero();  ///< where the rod starts
};

void DiscreteCosseratMapping::init() {
  LinkedMapping::init();
  base_ = base_link_.get();
  checkStates();
  for (std::size_t i = 0; i < section_ends_.size(); ++i)
    if (!(i == 0 || section_ends_[i] > section_ends_[i - 1]))
      throw ComponentError(fmt::format("curv_abs_input goes from {} to {}", section_ends_[i - 1], section_ends_[i]),
                           "ascending lengths");
  sections_.assign(section_ends_.size() - 1, {});
  starts_.assign(sections_.size(), {});
  for (std::size_t i = 0; i < sections_.size(); ++i)
    sections_[i].section = i, sections_[i].length = section_ends_[i + 1] - section_ends_[i];
  findFrames();
}

void DiscreteCosseratMapping::checkStates() {
  if (!base_) throw ComponentError("input2 is not given", "the state of the frame in which the rod starts");
  const bool has_curvatures = input().rows_per_node == 1 && input().kindOf(0) == RowKind::place;
  if (!has_curvatures && !(stretches() && input().kindOf(0) == RowKind::value))
    throw ComponentError(fmt::format("{} has no curvatures", input().path()),
                         "a state of template Vec3 or Vec6, a node for each section");
  if (!base_->hasFrames() || base_index_ >= base_->nodes())
    throw ComponentError(fmt::format("{} has no frame {}", base_->path(), base_index_), "a frame of a state of template Rigid3");
  if (!output().hasFrames()) throw ComponentError(fmt::format("{} has no frames", output().path()), "a state of template Rigid3");
  if (base_ == &output() || base_ == &input()) throw ComponentError("input2 is one of the other two states", "three states");
  if (Index(section_ends_.size()) != input().nodes() + 1)
    throw ComponentError(fmt::format("curv_abs_input has {} lengths for the {} sections of {}", section_ends_.size(),
                                     input().nodes(), input().path()),
                         "one more than sections: from the start of the rod to its end");
  if (Index(frame_places_.size()) != output().nodes())
    throw ComponentError(fmt::format("curv_abs_output has {} lengths for the {} frames of {}", frame_places_.size(),
                                     output().nodes(), output().path()),
                         "one for each frame");
}

void DiscreteCosseratMapping::findFrames() {
  const double whole = section_ends_.back() - section_ends_.front(), slack = 1e-9 * whole;
  frames_.assign(frame_places_.size(), {});
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    const double place = frame_places_[f];
    if (!(place >= section_ends_.front() - slack && place <= section_ends_.back() + slack))
      throw ComponentError(fmt::format("a frame at {} is not on the rod", place),
                           fmt::format("{} to {}", section_ends_.front(), section_ends_.back()));
    std::size_t section = 0;
    while (section + 1 < sections_.size() && place > section_ends_[section + 1]) ++section;
    frames_[f].section = section;
    frames_[f].length = std::clamp(place - section_ends_[section], 0., sections_[section].length);
  }
}

DiscreteCosseratMapping::Strains DiscreteCosseratMapping::strainsIn(ConstRows rows, std::size_t section) const {
  const Index first = rowOf(section);
  if (!stretches()) return {rows[first], Vec3::Zero()};
  const auto three = [&](Index from) { return Vec3(rows[from][0], rows[from + 1][0], rows[from + 2][0]); };
  return {three(first), three(first + 3)};
}

void DiscreteCosseratMapping::addTo(Rows rows, std::size_t section, const Strains& strains) const {
  const Index first = rowOf(section);
  if (!stretches()) return void(rows[first] += strains.curvature);
  for (Index c = 0; c < 3; ++c) {
    rows[first + c][0] += strains.curvature[c];
    rows[first + 3 + c][0] += strains.stretch[c];
  }
}

void DiscreteCosseratMapping::bend(Span& span, const Vec3& start, const Mat3& axes, const Strains& strains) const {
  span.piece = BentPiece(span.length, strains.curvature, Vec3::UnitX() + strains.stretch);
  span.axes = axes;
  span.end = start + axes * span.piece.way();
  span.turning = span.length * axes * span.piece.spin();
  for (int c = 0; c < 3; ++c) span.moving.col(c) = axes * span.piece.wayBy(span.length * Vec3::Unit(c), span.piece.axis);
}

void DiscreteCosseratMapping::apply(Rows x) const {
  pivot_ = x[baseRow()];
  Quaternion turn = orientationIn(x, baseRow() + 1);
  Vec3 start = pivot_;
  for (Span& section : sections_) {
    section.turn = turn;
    bend(section, start, turn.toRotationMatrix(), strainsIn(x, section.section));
    start = section.end, turn = turn * turnedBy(section.piece.turn);
  }
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    Span& frame = frames_[f];
    const Vec3 from = frame.section == 0 ? pivot_ : sections_[frame.section - 1].end;
    bend(frame, from, sections_[frame.section].axes, strainsIn(x, frame.section));
    x[row(f)] = frame.end;
    putOrientation(sections_[frame.section].turn * turnedBy(frame.piece.turn), x, row(f) + 1);
  }
}

void DiscreteCosseratMapping::applyJ(Rows v) const {
  Twin motion{v[baseRow()], v[baseRow() + 1]};
  for (const Span& section : sections_) {
    starts_[section.section] = motion;
    motion = carried(motion, section, strainsIn(v, section.section));
  }
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    const Span& frame = frames_[f];
    const Twin own = carried(starts_[frame.section], frame, strainsIn(v, frame.section));
    v[row(f)] = own.linear, v[row(f) + 1] = own.angular;
  }
}

/// Of each frame to the start of its section, then from section to section back to the base.
void DiscreteCosseratMapping::applyJT(Rows f) const {
  std::fill(starts_.begin(), starts_.end(), Twin{});
  const auto bringBack = [&](const Twin& load, const Span& span, Twin& start) {
    addTo(f, span.section, {span.moving.transpose() * load.linear + span.turning.transpose() * load.angular,
                            span.turning.transpose() * load.linear});
    start.linear += load.linear;
    start.angular += load.angular + (span.axes * span.piece.way()).cross(load.linear);
  };
  for (std::size_t k = 0; k < frames_.size(); ++k) bringBack({f[row(k)], f[row(k) + 1]}, frames_[k], starts_[frames_[k].section]);
  for (std::size_t i = sections_.size(); i-- > 1;) bringBack(starts_[i], sections_[i - 1], starts_[i - 1]);
  f[baseRow()] += starts_.front().linear;
  f[baseRow() + 1] += starts_.front().angular;
}

void DiscreteCosseratMapping::addJacobian(std::vector<JacobianBlock>& out) const {
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const Vec3 place = frames_[k].end;
    out.push_back({row(k), baseRow(), Mat3::Identity()});
    out.push_back({row(k), baseRow() + 1, -crossMatrix(place - pivot_)});
    out.push_back({row(k) + 1, baseRow() + 1, Mat3::Identity()});
    alongTo(frames_[k], [&](const Span& span) { addColumns(k, span, out); });
  }
}

void DiscreteCosseratMapping::addColumns(std::size_t frame, const Span& span, std::vector<JacobianBlock>& out) const {
  const Mat3 moving = span.moving - crossMatrix(frames_[frame].end - span.end) * span.turning;
  if (!stretches()) {
    out.push_back({row(frame), rowOf(span.section), moving});
    out.push_back({row(frame) + 1, rowOf(span.section), span.turning});
    return;
  }
  const auto add = [&](Index child, Index strain, const Vec3& column) {
    Mat3 block = Mat3::Zero();
    block.col(0) = column;
    out.push_back({child, rowOf(span.section) + strain, block});
  };
  for (Index c = 0; c < 3; ++c) {
    add(row(frame), c, moving.col(c)), add(row(frame) + 1, c, span.turning.col(c));
    add(row(frame), 3 + c, span.turning.col(c));
  }
}

/// The accelerations of frames where those of the base and of the curvatures are zero, from span to span.
void DiscreteCosseratMapping::addCurvature(ConstRows v, Rows a) const {
  if (!convects_) return;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    Vec3 spin = v[baseRow() + 1];
    Twin gained;
    alongTo(frames_[k], [&](const Span& span) {
      const auto [rate, stretch_rate] = strainsIn(v, span.section);
      const Vec3 turn_rate = span.length * rate, arm = span.axes * span.piece.way();
      gained.linear += gained.angular.cross(arm) + spin.cross(spin.cross(arm)) + 2 * spin.cross(span.moving * rate) +
                       span.axes * span.piece.wayTwiceBy(turn_rate);
      if (stretches())
        gained.linear += 2 * spin.cross(span.turning * stretch_rate) + 2 * (span.axes * span.piece.wayBy(turn_rate, stretch_rate));
      const Vec3 own = span.turning * rate;
      gained.angular += spin.cross(own) + span.axes * span.piece.spinTwiceBy(turn_rate);
      spin += own;
    });
    a[row(k)] += gained.linear, a[row(k) + 1] += gained.angular;
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(discrete_cosserat_mapping) {
  factory.add<stroma::DiscreteCosseratMapping>("DiscreteCosseratMapping", "frames on a rod of sections with constant strains");
}
