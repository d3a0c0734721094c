// SPDX-License-Identifier: LGPL-2.1-or-later
// With m the middle of a point's chord a rigid motion has x1 - x0 = p + q x m for all points, where q = 2 tan(|w|/2) w/|w|.
#include "components/contact/rigid_paths.h"

#include <Eigen/Dense>

#include <cmath>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/mapping.h"
#include "framework/scene/node.h"

namespace stroma::contact {

void RigidPaths::compile(const Surfaces& surfaces, const std::vector<State*>& bodies) {
  frames_.clear();
  std::vector<Mapping*> mappings;
  bodies.front()->node().root().collect(mappings);
  const std::vector<char> rigid = areRigid(surfaces, bodies);
  for (std::size_t i = 0; i < rigid.size(); ++i) {
    const Surfaces::Body& body = surfaces.bodies()[i];
    if (!rigid[i] || !body.moves || body.vertices == 0) continue;
    const State* const state = bodies[std::size_t(surfaces.bodyOf(body.first_vertex))];
    for (const Mapping* mapping : mappings)
      if (&mapping->output() == state)
        frames_.push_back({std::size_t(body.first_vertex), std::size_t(body.first_vertex + body.vertices), mapping->input().firstRow()});
  }
}

void RigidPaths::find(const std::vector<Vec3>& start, const std::vector<Vec3>& x, ConstRows rows) {
  ways_.resize(x.size());
  for (std::size_t v = 0; v < x.size(); ++v) ways_[v] = x[v] - start[v];
  turns_ = false;
  for (const Frame& frame : frames_) {
    const double part = 1 / double(frame.end - frame.first);
    Vec3 middle = Vec3::Zero(), way = Vec3::Zero();
    for (std::size_t v = frame.first; v < frame.end; ++v) middle += part * 0.5 * (start[v] + x[v]), way += part * ways_[v];
    Mat3 a = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (std::size_t v = frame.first; v < frame.end; ++v) {
      const Vec3 r = 0.5 * (start[v] + x[v]) - middle;
      a += r.squaredNorm() * Mat3::Identity() - r * r.transpose();
      b += r.cross(ways_[v] - way);
    }
    const Vec3 q = a.completeOrthogonalDecomposition().solve(b);  // points on a line say nothing of turns about it
    const double size = q.norm();
    const Vec3 w = size > 0 ? Vec3(2 * std::atan(0.5 * size) / size * q) : Vec3::Zero();
    turns_ = turns_ || size > 1e-6;
    const Vec3 o = rows[frame.row];
    const Vec3 d = (Mat3::Identity() + 0.5 * crossMatrix(q)).inverse() * (way + q.cross(o - middle));
    for (std::size_t v = frame.first; v < frame.end; ++v) ways_[v] = d + w.cross(x[v] - o);
  }
}

}  // namespace stroma::contact
