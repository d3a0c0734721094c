// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/accuracy_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

namespace stroma::bench {

std::vector<std::string> beamMesh(int cells) {
  return {fmt::format("/beam/grid.n={} {} {}", 10 * cells + 1, cells + 1, cells + 1)};
}

std::vector<std::string> cubeMesh(int cells) {
  return {fmt::format("/grid.n={0} {0} {0}", cells + 1)};
}

std::vector<std::string> barMesh(int cells) {
  return {fmt::format("/grid.n={0} {0} {1}", cells + 1, 2 * cells + 1)};
}

std::vector<std::string> blockMesh(int cells) { return barMesh(cells); }

std::vector<std::string> columnMesh(int cells) {
  return {fmt::format("/column/grid.n=2 2 {}", cells + 1)};
}

std::vector<std::string> ownMesh(int) { return {}; }

std::vector<std::string> cookMesh(int n) {
  std::string position, cells;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n, low = 44 * s, high = 44 + 16 * s;
        position += fmt::format("{} {} {} ", 48 * s, low + (high - low) * j / n, k);
        if (k > 0 || i == n || j == n) continue;
        for (int a : {0, 1})
          cells += fmt::format("{} {} {} {} ", node(i, j, a), node(i + 1, j, a), node(i + 1, j + 1, a), node(i, j + 1, a));
      }
  return {"/mesh.position=" + position, "/mesh.hexahedra=" + cells};
}

std::vector<std::string> muscleMesh(int n) { return {fmt::format("/grid.n={} {} {}", 10 * n + 1, n + 1, n + 1)}; }

std::vector<std::string> memoryMesh(int n) { return muscleMesh(n); }

namespace {

using Point = std::array<double, 3>;

/// n layers of three patches of n x n cells each, whose nodes are those of three sides of a cube. `place_of`: a direction from the
/// middle, in the first octant and of unit length, at a share of the wall from inside; the directions lie at equal angles.
std::vector<std::string> shellMesh(int n, const std::function<Point(const Point& direction, double share)>& place_of) {
  std::map<std::array<int, 3>, int> numbers;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        if (std::max({i, j, k}) == n) numbers.emplace(std::array{i, j, k}, 0);
  int count = 0;
  for (auto& [place, number] : numbers) number = count++;
  std::string position, cells, quads;
  for (int layer = 0; layer <= n; ++layer)
    for (const auto& [place, number] : numbers) {
      Point d{};
      double square = 0;
      for (std::size_t a = 0; a < 3; ++a) d[a] = std::tan(std::numbers::pi / 4 * place[a] / n), square += d[a] * d[a];
      for (double& part : d) part /= std::sqrt(square);
      const Point at = place_of(d, double(layer) / n);
      position += fmt::format("{:.17g} {:.17g} {:.17g} ", at[0], at[1], at[2]);
    }
  for (std::size_t a = 0; a < 3; ++a)
    for (int u = 0; u < n; ++u)
      for (int v = 0; v < n; ++v) {
        std::array<int, 4> ring{};  // turns around the outward normal
        for (std::size_t corner = 0; corner < 4; ++corner) {
          std::array<int, 3> place{};
          place[a] = n, place[(a + 1) % 3] = u + (corner == 1 || corner == 2), place[(a + 2) % 3] = v + (corner >= 2);
          ring[corner] = numbers.at(place);
        }
        quads += fmt::format("{} {} {} {} ", ring[3], ring[2], ring[1], ring[0]);  // into the hollow
        for (int layer = 0; layer < n; ++layer)
          for (int end : {layer, layer + 1})
            for (const int node : ring) cells += fmt::format("{} ", end * count + node);
      }
  return {"/mesh.position=" + position, "/mesh.hexahedra=" + cells, "/mesh.quads=" + quads};
}

}  // namespace

std::vector<std::string> chamberMesh(int n) {
  constexpr double inner = 10, wall = 10;
  return shellMesh(n, [](const Point& direction, double share) {
    const double radius = inner + wall * share;
    return Point{radius * direction[0], radius * direction[1], radius * direction[2]};
  });
}

/// The third direction becomes the apex, below, and what is across it the base. Angles from the apex are stretched evenly.
std::vector<std::string> ventricleMesh(int n) {
  constexpr double short_inner = 7, long_inner = 17, wall = 3, base = 5;
  return shellMesh(n, [](const Point& d, double share) {
    const double across = std::hypot(d[0], d[1]), angle = std::atan2(across, d[2]) / (std::numbers::pi / 2);
    const double long_axis = long_inner + wall * share, u = angle * (std::numbers::pi - std::acos(base / long_axis));
    const double radius = across > 0 ? (short_inner + wall * share) * std::sin(u) / across : 0;
    return Point{radius * d[1], radius * d[0], -long_axis * std::cos(u)};
  });
}

}  // namespace stroma::bench
