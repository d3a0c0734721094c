// SPDX-License-Identifier: LGPL-2.1-or-later
// Two bodies and obstacles for tests of what is near, and searches through all of their pairs.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <tuple>

#include "components/contact/contact_candidates.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {

using contact::Candidates;
using contact::Surfaces;

/// Two boxes with a body's number of cells each, a sphere and a capsule.
struct Scenery {
  Simulation simulation;
  Surfaces surfaces;
  std::vector<Vec3> x;
  std::mt19937 random;

  explicit Scenery(unsigned seed)
      : simulation(simulationFromText(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {3, 2, 2}), "") +
                                                   bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 3, 2}), "")))),
        random(seed) {
    for (const State* state : simulation.states()) surfaces.addState(*state, topologyOf(*state)->mesh());
    surfaces.addObstacle({Vec3(0.5, 0.5, -0.3)}, {{0, 0, 0}}, 0.25);
    surfaces.addObstacle({Vec3(-0.5, -0.2, 0.5), Vec3(1.5, -0.2, 0.6)}, {{0, 0, 1}}, 0.15);
    surfaces.finish();
    x = surfaces.rest;
    const Mat3 turn = Eigen::AngleAxisd(3 * number(), Vec3(number(), number(), number()).normalized()).toRotationMatrix();
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (surfaces.bodyOf(int(v)) == 1) x[v] = turn * x[v] + Vec3(0.2, 0.2, 1.2 + 0.3 * number());
      if (surfaces.bodyOf(int(v)) < 2) x[v] += 0.02 * Vec3(number(), number(), number());
    }
  }
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random); }
};

using Key = std::tuple<PairKind, int, int>;

/// visit(kind, first, second, its points) of every pair of two sides that share no vertex; obstacles do not meet each other.
template <class Visit>
void forEachPair(const Surfaces& s, Visit&& visit) {
  const auto meet = [&](int a, int b) { return s.moves(a) || s.moves(b); };
  for (std::size_t v = 0; v < s.rows.size(); ++v)
    for (std::size_t f = 0; f < s.faces.size(); ++f) {
      const auto& [a, b, c] = s.faces[f];
      if (meet(int(v), a) && int(v) != a && int(v) != b && int(v) != c)
        visit(PairKind::point_triangle, int(v), int(f), std::array{int(v), a, b, c});
    }
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t g = e + 1; g < s.edges.size(); ++g) {
      const auto& [a, b] = s.edges[e];
      const auto& [c, d] = s.edges[g];
      if (meet(a, c) && a != c && a != d && b != c && b != d)
        visit(PairKind::edge_edge, int(e), int(g), std::array{a, b, c, d});
    }
}

inline FourPoints at(const std::array<int, 4>& v, const std::vector<Vec3>& x) {
  FourPoints out;
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(out[i].data(), x[std::size_t(v[i])].data(), 3 * sizeof(double));
  return out;
}

inline std::set<std::pair<int, int>> edgesOf(const std::vector<Candidates::Crossing>& crossings) {
  std::set<std::pair<int, int>> edges;
  for (const auto& crossing : crossings) edges.insert({crossing.edge, crossing.face});
  return edges;
}

inline double radiusAt(const Surfaces& s, int vertex) {
  return s.radius[std::size_t(s.faces_around.values[std::size_t(s.faces_around.start[std::size_t(vertex)])])];
}

/// A step as long as every pair lets it be, each asked alone: none is brought nearer than a tenth of its distance. A pair may be left
/// out of it that stays farther apart than a tenth of the reach. Beyond that round-off counts alone: 2e-12 of a size of one, of gaps
/// from a ten-thousandth on. What comes straight on is at a tenth after its first advance, and round-off says whether that ends it.
inline void expectLongestStep(const Surfaces& s, const std::vector<Vec3>& x, const std::vector<Vec3>& way, double reach, double step) {
  constexpr double round_off = 1e-6, another = 0.1;
  double shortest = 1, longest = 1;
  forEachPair(s, [&](PairKind kind, int, int, const std::array<int, 4>& v) {
    const FourPoints start = at(v, x), along = at(v, way);
    const double radii = radiusAt(s, v[0]) + radiusAt(s, v[3]), room = closestPoints(kind, start).distance() - radii;
    double moves = 0;
    for (const Vec3& each : along) {
      const double* m = each.data();
      moves = std::max(moves, std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]));
    }
    if (2 * moves < 0.9 * room) return;
    const double first = stroma::longestStep(kind, start, along, {.thickness = radii, .left = 0.1 * (1 + round_off)});
    shortest = std::min(shortest, first);
    if (first < longest)
      longest = std::min(longest, stroma::longestStep(kind, start, along,
                                                      {.thickness = radii, .left = 0.1 * (1 - round_off) * std::min(1.0, reach / room)}));
  });
  EXPECT_GE(step, shortest / (1 + another) * (1 - round_off));
  EXPECT_LE(step, longest * (1 + another) * (1 + round_off));
}

}  // namespace stroma::test
