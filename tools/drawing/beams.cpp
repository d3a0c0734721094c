// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/beams.h"

#include <algorithm>
#include <limits>

#include "framework/mechanics/state_positions.h"

namespace stroma::drawing {

void addBeam(Body& body, Index a, Index b, double radius) {
  const std::vector<Vec3>& rest = body.state->rest_position;
  const Vec3 chord = rest[std::size_t(b)] - rest[std::size_t(a)];
  Beam beam{{a, b}, {}, radius, {}};
  for (std::size_t end : {0, 1})
    beam.chord[end] = turnedBy(rest[std::size_t(beam.nodes[end] + 1)]).conjugate() * chord;
  body.beams.push_back(beam);
}

void dropEdgesOfBeams(Body& body) {
  std::vector<Edge> beams;
  for (const Beam& beam : body.beams)
    beams.push_back({std::min(beam.nodes[0], beam.nodes[1]), std::max(beam.nodes[0], beam.nodes[1])});
  std::sort(beams.begin(), beams.end());
  std::erase_if(body.edges, [&](const Edge& edge) {
    return std::binary_search(beams.begin(), beams.end(), Edge{std::min(edge[0], edge[1]), std::max(edge[0], edge[1])});
  });
}

void chooseSizes(std::vector<Body>& bodies) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Body& body : bodies)
    for (const Index row : body.node) {
      low = low.cwiseMin(body.state->rest_position[std::size_t(row)]);
      high = high.cwiseMax(body.state->rest_position[std::size_t(row)]);
    }
  const double size = low[0] <= high[0] ? (high - low).norm() : 0;
  double largest = 0;
  for (Body& body : bodies) {
    body.size = restSize(*body.state);
    for (const Ball& ball : body.balls) body.size = std::max(body.size, 2 * ball.radius);
    largest = std::max(largest, body.size);
  }
  // bodies that are far apart have axes as long as they need, not as their distance
  const double scene = largest > 0 ? std::min(size, 5 * largest) : size;
  for (Body& body : bodies) {
    body.axis = scene > 0 ? 0.08 * scene : 1;
    if (!(body.size > 0)) body.size = size > 0 ? size : 1;
    std::vector<double> ways;
    for (std::size_t i = 1; i < body.frames.size(); ++i) {
      const auto place = [&](std::size_t frame) { return body.state->rest_position[std::size_t(body.frames[frame][1] - 1)]; };
      if (const double way = (place(i) - place(i - 1)).norm(); way > 0) ways.push_back(way);
    }
    if (ways.empty()) continue;
    std::nth_element(ways.begin(), ways.begin() + long(ways.size() / 2), ways.end());
    body.axis = std::min(body.axis, 0.35 * ways[ways.size() / 2]);
  }
}

std::vector<Vec3> beamCurve(const Beam& beam, const Vec3& a, const Vec3& b, const Quaternion& turn_a, const Quaternion& turn_b,
                            int pieces) {
  // the ends of an arc have tangents as long as the arc, whatever its chord is now
  const Vec3 from = turn_a * beam.chord[0], to = turn_b * beam.chord[1];
  std::vector<Vec3> places;
  for (int i = 0; i <= pieces; ++i) {
    const double s = double(i) / pieces, square = s * s, cube = square * s;
    places.push_back((2 * cube - 3 * square + 1) * a + (cube - 2 * square + s) * from + (3 * square - 2 * cube) * b +
                     (cube - square) * to);
  }
  return places;
}

}  // namespace stroma::drawing
