// SPDX-License-Identifier: LGPL-2.1-or-later
// LineSetSkinningMapping: points that follow the lines of a skeleton, each line by the frame at its first node.
//
//   x_i = sum_l w_il (c_l + q_l p_il),   sum_l w_il = 1,   w_il ~ |l| mean over the line of 1/d^k
//
// p_il is the initial position of point i in the axes of the frame c_l, q_l; d is the distance of the point from a point on
// the line, and k is weightCoef. The mean is over 1001 points. The line with the largest weight is used, and the next ones
// that are near it in the mesh, numberInfluencedLines in all: those within neighborhoodLevel steps. A step leads to lines that
// share a node, except for two lines that only end at the same one.
//
// Source: the name, the attributes and the rules are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  2 0 0" lines="0 1  1 2"/>
//   <MechanicalObject name="bones" template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1   2 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="skin">
//     <MechanicalObject name="points" position="0.5 0.2 0  1 0.2 0  1.5 0.2 0"/>
//     <LineSetSkinningMapping weightCoef="4"/>
//     <ConstantForceField indices="1" forces="0 0 0.1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "components/mappings/frame_mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LineSetSkinningMapping final : public FrameMapping {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.add("neighborhoodLevel", steps_).help("steps from the nearest line to others that may count").min(1);
    table.add("numberInfluencedLines", most_).help("lines that a point follows at most").min(1);
    table.add("weightCoef", power_).help("k, power of the distance").min(0);
  }

  void init() override {
    FrameMapping::init();
    start();
    if (!output().hasPointsOnly()) throw ComponentError(output().path() + " has other nodes than points", "points");
    const Topology* topology = topologyOf(input());
    if (topology) lines_ = topology->mesh().edges.empty() ? topology->mesh().allEdges() : topology->mesh().edges;
    if (lines_.empty()) throw ComponentError(fmt::format("{} has no mesh with lines", input().path()), "lines between its frames");
    const std::vector<std::set<std::size_t>> near = linesNear();
    for (const Vec3& place : std::vector<Vec3>(output().position)) addPoint(linesOf(place, near));
    placeChild(false);
  }

 private:
  struct Pull {
    double weight = 0;
    std::size_t line = 0;
  };

  /// Of each line those within so many steps, and itself.
  std::vector<std::set<std::size_t>> linesNear() const {
    std::vector<std::set<std::size_t>> next(lines_.size());
    for (std::size_t a = 0; a < lines_.size(); ++a)
      for (std::size_t b = 0; b < lines_.size(); ++b)
        if (lines_[a][0] == lines_[b][0] || lines_[a][0] == lines_[b][1] || lines_[a][1] == lines_[b][0]) next[a].insert(b);
    std::vector<std::set<std::size_t>> near = next;
    for (std::set<std::size_t>& lines : near)
      for (int step = 1; step < steps_; ++step) {
        const std::set<std::size_t> before = lines;
        for (const std::size_t line : before) lines.insert(next[line].begin(), next[line].end());
      }
    return near;
  }

  double weightOf(std::size_t line, const Vec3& place) const {
    constexpr int parts = 1000;
    const Vec3 first = centre(lines_[line][0]), along = centre(lines_[line][1]) - first;
    double sum = 0;
    for (int i = 0; i <= parts; ++i) sum += std::pow(1 / (along * i / parts + first - place).norm(), power_);
    return sum * along.norm() / parts;
  }

  std::vector<Carried> linesOf(const Vec3& place, const std::vector<std::set<std::size_t>>& near) const {
    std::vector<Pull> pulls;
    for (std::size_t line = 0; line < lines_.size(); ++line) pulls.push_back({weightOf(line, place), line});
    for (const Pull& pull : pulls)
      if (!std::isfinite(pull.weight))
        throw ComponentError(fmt::format("the point {:.3g} {:.3g} {:.3g} lies on line {}", place[0], place[1], place[2], pull.line),
                             "points beside the lines");
    // of equal ones the last comes first
    std::sort(pulls.begin(), pulls.end(),
              [](const Pull& a, const Pull& b) { return a.weight > b.weight || (a.weight == b.weight && a.line > b.line); });
    std::vector<Carried> by;
    double sum = 0;
    for (const Pull& pull : pulls) {
      const bool counts = by.empty() || near[pulls[0].line].count(pull.line);
      if (!counts || by.size() >= std::size_t(most_)) continue;
      const Index frame = lines_[pull.line][0];
      by.push_back({frame, pull.weight, orientation(frame).conjugate() * (place - centre(frame))});
      sum += pull.weight;
    }
    for (Carried& one : by) one.weight /= sum;
    return by;
  }

  int steps_ = 3, most_ = 4, power_ = 4;
  std::vector<Edge> lines_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(line_set_skinning_mapping) {
  factory.add<stroma::LineSetSkinningMapping>("LineSetSkinningMapping", "points that follow the lines of a skeleton");
}
