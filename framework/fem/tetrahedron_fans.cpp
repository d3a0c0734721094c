// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/fem/tetrahedron_fans.h"

#include <algorithm>

namespace stroma::tetrahedron {
namespace {

using Neighbours = std::vector<std::array<Index, 4>>;

/// neighbour[e][a]: the tetrahedron across the face opposite vertex a; -1 at the surface. Where more than two share a
/// face (cells that cover a body twice), any two of them are neighbours.
Neighbours neighboursOf(const std::vector<Tetrahedron>& cells, std::size_t node_count) {
  struct Face {
    std::array<Index, 2> others;  // the two larger nodes
    Index element, vertex;
  };
  // faces by their smallest node
  std::vector<Index> start(node_count + 1, 0);
  for (const Tetrahedron& cell : cells)
    for (int a = 0; a < 4; ++a) ++start[std::size_t(std::min({cell[(a + 1) % 4], cell[(a + 2) % 4], cell[(a + 3) % 4]})) + 1];
  for (std::size_t n = 0; n < node_count; ++n) start[n + 1] += start[n];
  std::vector<Face> faces(4 * cells.size());
  std::vector<Index> next(start.begin(), start.end() - 1);
  for (std::size_t e = 0; e < cells.size(); ++e)
    for (int a = 0; a < 4; ++a) {
      std::array<Index, 3> face = {cells[e][(a + 1) % 4], cells[e][(a + 2) % 4], cells[e][(a + 3) % 4]};
      std::sort(face.begin(), face.end());
      faces[next[face[0]]++] = {{face[1], face[2]}, Index(e), a};
    }
  Neighbours neighbour(cells.size(), {-1, -1, -1, -1});
  for (std::size_t n = 0; n < node_count; ++n)
    for (Index i = start[n]; i < start[n + 1]; ++i) {
      const Face& face = faces[i];
      if (neighbour[face.element][face.vertex] >= 0) continue;
      for (Index j = i + 1; j < start[n + 1]; ++j) {
        const Face& other = faces[j];
        if (other.others != face.others || neighbour[other.element][other.vertex] >= 0) continue;
        neighbour[face.element][face.vertex] = other.element;
        neighbour[other.element][other.vertex] = face.element;
        break;
      }
    }
  return neighbour;
}

/// partner[e], -1 for none. A tetrahedron with a single free neighbour must take it now or stay alone, so those go
/// first (Karp and Sipser 1981); the others in the order of the cells.
std::vector<Index> matchFaces(const Neighbours& neighbour) {
  std::vector<Index> partner(neighbour.size(), -1);
  std::vector<char> taken(neighbour.size(), 0);
  const auto isFree = [&](Index e) { return e >= 0 && !taken[e]; };
  const auto freeNeighbours = [&](Index e) { return int(std::count_if(neighbour[e].begin(), neighbour[e].end(), isFree)); };
  std::vector<Index> urgent;
  const auto match = [&](Index e) {
    Index best = -1;
    int fewest = 5;
    for (Index other : neighbour[e])
      if (isFree(other) && other != e && freeNeighbours(other) < fewest) best = other, fewest = freeNeighbours(other);
    if (best < 0) return;
    partner[e] = best, partner[best] = e;
    taken[e] = taken[best] = 1;
    for (Index matched : {e, best})
      for (Index other : neighbour[matched])
        if (isFree(other) && freeNeighbours(other) == 1) urgent.push_back(other);
  };
  for (Index e = 0; e < Index(neighbour.size()); ++e) {
    if (isFree(e)) match(e);
    while (!urgent.empty()) {
      const Index next = urgent.back();
      urgent.pop_back();
      if (isFree(next)) match(next);
    }
  }
  return partner;
}

}  // namespace

std::vector<Fan> gatherFans(const std::vector<Tetrahedron>& cells, std::size_t node_count) {
  static_assert(fan_size == 2, "a fan is made of two tetrahedra that share a face");
  const Neighbours neighbour = neighboursOf(cells, node_count);
  const std::vector<Index> partner = matchFaces(neighbour);
  std::vector<Fan> fans;
  fans.reserve(cells.size() / 2 + 1);
  for (Index e = 0; e < Index(cells.size()); ++e) {
    const Index other = partner[e];
    if (other >= 0 && other < e) continue;
    const Tetrahedron& first = cells[e];
    if (other < 0) {
      fans.push_back({{first[0], first[1], first[2], first[3], first[2]}, {e, -1}});
      continue;
    }
    const auto across = std::find(neighbour[e].begin(), neighbour[e].end(), other);
    const std::size_t apex = std::size_t(across - neighbour[e].begin());
    const Index a = first[(apex + 1) % 4], b = first[(apex + 2) % 4], c = first[(apex + 3) % 4];
    const Tetrahedron& second = cells[other];
    const auto far = std::find_if(second.begin(), second.end(), [&](Index n) { return n != a && n != b && n != c; });
    fans.push_back({{a, b, first[apex], c, far == second.end() ? first[apex] : *far}, {e, other}});
  }
  return fans;
}
std::vector<std::array<Index, fan_nodes>> nodesOf(const std::vector<Fan>& fans) {
  std::vector<std::array<Index, fan_nodes>> nodes(fans.size());
  std::transform(fans.begin(), fans.end(), nodes.begin(), [](const Fan& fan) { return fan.nodes; });
  return nodes;
}

}  // namespace stroma::tetrahedron
