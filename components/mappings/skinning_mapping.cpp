// SPDX-License-Identifier: LGPL-2.1-or-later
// SkinningMapping: points that follow several rigid frames, each by its weight.
//
//   x_i = sum_j w_ij (c_j + q_j p_ij),   sum_j w_ij = 1
//
// p_ij is the initial position of point i in the axes of frame j. The frames of a point are its nbRef nearest ones, with
// weights proportional to 1/d^2, d the distance of the frame's centre (a point on a centre follows only that frame, and of
// equally near frames the first one is used, with fromRest the last one); or those of `indices`, nbRef for each point, with
// `weight` for each. Known as linear blend skinning. `nbRef` may also list a number for each point.
//
// Source: the name and the attributes are SOFA's, which has the frames as they rest (fromRest).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject name="bones" template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="skin">
//     <MechanicalObject name="points" position="0.25 0.1 0  0.5 0.1 0  0.75 0.1 0"/>
//     <SkinningMapping nbRef="2"/>
//     <ConstantForceField indices="1" forces="0 0 0.1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/mappings/frame_mapping.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SkinningMapping final : public FrameMapping {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.add("nbRef", counts_).help("frames of a point, one number for all or one for each").min(1);
    table.add("indices", indices_).help("frames of the points, nbRef for each; the nearest ones by default");
    table.add("weight", weights_).help("weights of `indices`").unit("-");
    table.add("initPos", initial_points_)
        .unit("m")
        .help("places of the points in space at the start; the positions of the child by default");
    table.add("fromRest", from_rest_)
        .help("points are bound to the frames at rest, not at the start; of equally near frames the last ones are used");
    for (const char* name : {"showFromIndex", "showWeights"}) table.addVisualOnly(name);
  }

  void init() override {
    FrameMapping::init();
    start();
    if (!output().hasPointsOnly()) throw ComponentError(output().path() + " has other nodes than points", "points");
    if (!initial_points_.empty() && Index(initial_points_.size()) != output().size())
      throw ComponentError(fmt::format("initPos has {} points for the {} of {}", initial_points_.size(),
                                       output().size(), output().path()),
                           "as many");
    const std::vector<Vec3> places = initial_points_.empty() ? output().position : initial_points_;
    if (counts_.size() != 1 && counts_.size() != places.size())
      throw ComponentError(fmt::format("nbRef has {} values for {} points", counts_.size(), places.size()),
                           "1 value or one for each");
    std::size_t next = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const std::size_t count = std::size_t(counts_[counts_.size() == 1 ? 0 : i]);
      std::vector<Carried> by = indices_.empty() ? nearest(places[i], count) : listed(next, count);
      next += count;
      for (Carried& one : by)
        one.local = orientation(one.frame, from_rest_).conjugate() * (places[i] - centre(one.frame, from_rest_));
      addPoint(by);
    }
    if (!indices_.empty() && next != indices_.size())
      throw ComponentError(fmt::format("indices has {} values, and nbRef wants {}", indices_.size(), next),
                           "nbRef for each point");
    placeChild(false);
  }

 private:
  std::vector<Carried> nearest(const Vec3& place, std::size_t count) const {
    std::vector<std::pair<double, Index>> order;
    for (Index frame = 0; frame < input().nodes(); ++frame)
      order.emplace_back((centre(frame, from_rest_) - place).squaredNorm(), frame);
    std::sort(order.begin(), order.end(), [this](const auto& a, const auto& b) {
      return a.first < b.first || (a.first == b.first && (from_rest_ ? a.second > b.second : a.second < b.second));
    });
    order.resize(std::min(order.size(), count));
    if (order.front().first == 0) return {{order.front().second, 1, Vec3::Zero()}};
    double sum = 0;
    for (const auto& [square, frame] : order) sum += 1 / square;
    std::vector<Carried> by;
    for (const auto& [square, frame] : order) by.push_back({frame, 1 / square / sum, Vec3::Zero()});
    return by;
  }

  std::vector<Carried> listed(std::size_t first, std::size_t count) const {
    if (first + count > indices_.size() || weights_.size() != indices_.size())
      throw ComponentError(fmt::format("indices has {} values and weight {}", indices_.size(), weights_.size()),
                           "nbRef of each for each point");
    std::vector<Carried> by;
    double sum = 0;
    for (std::size_t k = first; k < first + count; ++k) {
      if (indices_[k] < 0 || indices_[k] >= input().nodes())
        throw ComponentError(fmt::format("indices names frame {}", indices_[k]),
                             fmt::format("0 to {} of {}", input().nodes() - 1, input().path()));
      by.push_back({indices_[k], weights_[k], Vec3::Zero()}), sum += weights_[k];
    }
    if (!(sum > 0)) throw ComponentError("the weights of a point sum to zero", "weights of which one is positive");
    for (Carried& one : by) one.weight /= sum;
    return by;
  }

  std::vector<int> counts_{4}, indices_;
  std::vector<double> weights_;
  std::vector<Vec3> initial_points_;
  bool from_rest_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(skinning_mapping) {
  factory.add<stroma::SkinningMapping>("SkinningMapping", "points that follow several rigid frames by weights");
}
