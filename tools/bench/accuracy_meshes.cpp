// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/accuracy_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
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

/// Nodes of a layer are those of three sides of a cube, drawn to a sphere so that they lie at equal angles.
std::vector<std::string> chamberMesh(int n) {
  constexpr double inner = 10, wall = 10;
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
      std::array<double, 3> d{};
      double square = 0;
      for (std::size_t a = 0; a < 3; ++a) d[a] = std::tan(std::numbers::pi / 4 * place[a] / n), square += d[a] * d[a];
      const double scale = (inner + wall * layer / n) / std::sqrt(square);
      position += fmt::format("{:.17g} {:.17g} {:.17g} ", scale * d[0], scale * d[1], scale * d[2]);
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

}  // namespace stroma::bench
