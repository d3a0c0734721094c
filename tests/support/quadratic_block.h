// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes of quadratic tetrahedra made here, so that what is tested has made nothing of them.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "framework/mesh/mesh.h"
#include "framework/mesh/simplex_size.h"

namespace stroma::test {

struct QuadraticBlock {
  std::vector<Vec3> position;
  std::vector<Tetrahedron> linear;
  std::vector<QuadraticTetrahedron> cells;

  /// Raises tetrahedra: a node in the middle of each edge, in VTK's order.
  static QuadraticBlock raised(std::vector<Vec3> corners, std::vector<Tetrahedron> tetrahedra) {
    QuadraticBlock out{std::move(corners), std::move(tetrahedra), {}};
    std::map<std::array<Index, 2>, Index> middle;
    constexpr int pairs[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    for (const Tetrahedron& t : out.linear) {
      QuadraticTetrahedron& cell = out.cells.emplace_back();
      std::copy(t.begin(), t.end(), cell.begin());
      for (std::size_t e = 0; e < 6; ++e) {
        const Index a = t[std::size_t(pairs[e][0])], b = t[std::size_t(pairs[e][1])];
        const auto [at, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, Index(out.position.size()));
        if (is_new) out.position.push_back((out.position[std::size_t(a)] + out.position[std::size_t(b)]) / 2);
        cell[4 + e] = at->second;
      }
    }
    return out;
  }
  /// n[0] x n[1] x n[2] cubes of a box, six tetrahedra each around a diagonal; corners are moved by `place`.
  static QuadraticBlock box(const std::array<int, 3>& n, const std::function<Vec3(const Vec3&)>& place) {
    std::vector<Vec3> corners;
    const auto number = [&](int i, int j, int k) { return Index((k * (n[1] + 1) + j) * (n[0] + 1) + i); };
    for (int k = 0; k <= n[2]; ++k)
      for (int j = 0; j <= n[1]; ++j)
        for (int i = 0; i <= n[0]; ++i)
          corners.push_back(place(Vec3(double(i) / n[0], double(j) / n[1], double(k) / n[2])));
    std::vector<Tetrahedron> cells;
    constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i)
          for (const auto& order : orders) {
            int at[3] = {i, j, k};
            Tetrahedron t{number(i, j, k)};
            for (std::size_t s = 0; s < 3; ++s) ++at[order[s]], t[s + 1] = number(at[0], at[1], at[2]);
            const auto p = [&](int a) { return corners[std::size_t(t[std::size_t(a)])]; };
            if (tetrahedronVolume(p(0), p(1), p(2), p(3)) < 0) std::swap(t[2], t[3]);
            cells.push_back(t);
          }
    return raised(std::move(corners), std::move(cells));
  }
  /// Moves every node by up to `distance` in each direction: edges become curved.
  QuadraticBlock& crumple(double distance, unsigned seed = 3) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-distance, distance);
    for (Vec3& p : position) p += Vec3(uniform(random), uniform(random), uniform(random));
    return *this;
  }

  std::string positions() const {
    std::string text;
    for (const Vec3& p : position) text += fmt::format("{:.17g} {:.17g} {:.17g} ", p.x(), p.y(), p.z());
    return text;
  }
  std::string cellText() const {
    std::string text;
    for (const QuadraticTetrahedron& cell : cells)
      for (const Index n : cell) text += fmt::format("{} ", n);
    return text;
  }
  /// <MeshTopology .../> with these cells and `more` attributes.
  std::string topology(const std::string& more = "") const {
    return "<MeshTopology name=\"mesh\" position=\"" + positions() + "\" quadraticTetrahedra=\"" + cellText() + "\" " +
           more + "/>";
  }
};

/// A turned block of 2 x 3 x 2 cubes with curved edges under QuadraticTetrahedronFEMForceField or another field.
inline std::string quadraticScene(const std::string& attributes,
                                  const std::string& field =
                                      "QuadraticTetrahedronFEMForceField youngModulus=\"3000\" "
                                      "poissonRatio=\"0.4\"",
                                  const std::string& solver = "<SparseLDLSolver/>",
                                  const std::array<int, 3>& n = {2, 3, 2}, const std::string& more = "") {
  static std::map<std::array<int, 3>, std::string> written;  // the same for all methods, and long
  std::string& topology = written[n];
  if (topology.empty())
    topology = QuadraticBlock::box(n, [](const Vec3& p) {
                 return Vec3(0.04 * p.x() + 0.01 * p.y(), 0.05 * p.y() - 0.008 * p.z(), 0.06 * p.z() + 0.01 * p.x() * p.x());
               }).crumple(0.001 * 2 / n[0]).topology();
  return "<Node name=\"root\" dt=\"0.01\"><Node name=\"body\"><EulerImplicitSolver/>" + solver + topology +
         "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + field + " " + attributes + "/>" + more +
         "</Node></Node>";
}

}  // namespace stroma::test
