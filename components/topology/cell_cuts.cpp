// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/cell_cuts.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mesh/cell_kind.h"
#include "framework/scene/diagnostics.h"

namespace stroma {

namespace {

using Corners = std::array<int, 4>;

// Appendix B of Nesme et al. 2005 names a corner by the binary number zyx; here in VTK's numbering (0 1 3 2 4 5 7 6 for
// 0 to 7), the last two nodes exchanged where the printed order has a negative volume. The first node, on which the
// frame of the method `large` depends, is the paper's.
constexpr std::array<Corners, 5> five1_corners{{{1, 4, 5, 6}, {0, 1, 3, 4}, {1, 2, 3, 6}, {3, 4, 6, 7}, {1, 3, 4, 6}}};
constexpr std::array<Corners, 5> five2_corners{{{5, 0, 2, 1}, {4, 5, 0, 7}, {5, 6, 2, 7}, {7, 0, 3, 2}, {5, 7, 2, 0}}};
// SOFA's six around the diagonal 0-6, in its order; the second table for a cell turned inside out by an odd number of
// mirrors.
constexpr std::array<Corners, 6> six_corners{
    {{0, 5, 1, 6}, {0, 1, 3, 6}, {1, 3, 6, 2}, {6, 3, 0, 7}, {6, 7, 0, 5}, {7, 5, 4, 0}}};
constexpr std::array<Corners, 6> six_corners_odd{
    {{0, 5, 6, 1}, {0, 1, 6, 3}, {1, 3, 2, 6}, {6, 3, 7, 0}, {6, 7, 5, 0}, {7, 5, 0, 4}}};

template <std::size_t N>
void append(const Hexahedron& cell, const std::array<Corners, N>& corners, std::vector<Tetrahedron>& out) {
  for (const Corners& c : corners) out.push_back({cell[c[0]], cell[c[1]], cell[c[2]], cell[c[3]]});
}

/// Local nodes of a face.
const auto& faceOf(int face) { return cell_kinds::hexahedron.faces[face].nodes; }

using FaceNodes = std::array<Index, 4>;

struct CellFace {
  Index cell = 0;
  int face = 0;  ///< of CellKind::faces
};

FaceNodes nodesOf(const std::vector<Hexahedron>& cells, const CellFace& where) {
  FaceNodes nodes;
  for (std::size_t i = 0; i < 4; ++i) nodes[i] = cells[where.cell][faceOf(where.face)[i]];
  return nodes;
}

/// Pairs of cells that share a face, in ascending order of its sorted nodes.
std::vector<std::array<CellFace, 2>> sharedFaces(const std::vector<Hexahedron>& cells) {
  std::vector<std::pair<FaceNodes, CellFace>> keys;
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int f = 0; f < 6; ++f) {
      const CellFace where{Index(c), f};
      FaceNodes nodes = nodesOf(cells, where);
      std::sort(nodes.begin(), nodes.end());
      keys.emplace_back(nodes, where);
    }
  std::ranges::stable_sort(keys, {}, [](const auto& key) { return key.first; });
  std::vector<std::array<CellFace, 2>> out;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i)
    if (keys[i].first == keys[i + 1].first) out.push_back({keys[i].second, keys[i + 1].second});
  return out;
}

/// For each cell its faces with neighbours.
std::vector<std::array<CellFace, 6>> neighbours(const std::vector<Hexahedron>& cells,
                                                const std::vector<std::array<CellFace, 2>>& shared) {
  std::array<CellFace, 6> none;
  none.fill({-1, -1});
  std::vector<std::array<CellFace, 6>> out(cells.size(), none);
  for (const auto& [a, b] : shared) {
    out[a.cell][a.face] = b;
    out[b.cell][b.face] = a;
  }
  return out;
}

/// Visits the cells of each connected part in breadth-first order: `start(cell)` for its first one, then
/// `across(from, to)` over each pair of neighbours, in both directions. `across` says whether the pair fits.
template <class Start, class Across>
bool walk(const std::vector<Hexahedron>& cells, Start&& start, Across&& across) {
  const auto next = neighbours(cells, sharedFaces(cells));
  std::vector<char> seen(cells.size(), 0);
  std::vector<Index> queue;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = 1;
    start(Index(first));
    queue.assign(1, Index(first));
    for (std::size_t q = 0; q < queue.size(); ++q)
      for (int face = 0; face < 6; ++face) {
        const CellFace other = next[queue[q]][face];
        if (other.cell < 0) continue;
        const bool is_new = !seen[other.cell];
        if (!across({queue[q], face}, other, is_new)) return false;
        if (is_new) seen[other.cell] = 1, queue.push_back(other.cell);
      }
  }
  return true;
}

/// True when the edge of corners 0 and 2 of local face `face` belongs to the cut (else the edge of 1 and 3 does).
bool cutsFirstDiagonal(const std::array<Corners, 5>& corners, int face) {
  const auto& f = faceOf(face);
  return std::any_of(corners.begin(), corners.end(), [&f](const Corners& c) {
    return std::count(c.begin(), c.end(), f[0]) + std::count(c.begin(), c.end(), f[2]) == 2;
  });
}

/// 0 (five1) or 1 (five2) for each cell so that neighbours cut their common face along the same diagonal. The two cuts
/// differ on every face, so the choice for one cell settles its connected part.
std::vector<char> alternate(const std::vector<Hexahedron>& cells) {
  const auto diagonal = [&cells](const CellFace& where, char cut) -> std::pair<Index, Index> {
    const FaceNodes nodes = nodesOf(cells, where);
    const bool first = cutsFirstDiagonal(cut ? five2_corners : five1_corners, where.face);
    return first ? std::minmax(nodes[0], nodes[2]) : std::minmax(nodes[1], nodes[3]);
  };
  std::vector<char> choice(cells.size(), 0);
  const bool fits = walk(
      cells, [](Index) {},
      [&](const CellFace& from, const CellFace& to, bool is_new) {
        const std::pair<Index, Index> wanted = diagonal(from, choice[from.cell]);
        if (is_new) choice[to.cell] = diagonal(to, 0) == wanted ? 0 : 1;
        return diagonal(to, choice[to.cell]) == wanted;
      });
  if (!fits)
    throw ComponentError(
        "the hexahedra cannot be cut in five so that all faces match (a closed ring of an odd number of cells)",
        "cutting=\"ten\", which needs no matching faces");
  return choice;
}

/// SOFA mirrors in x the cells of even i, in y those of odd j, in z those of odd k. The tetrahedra of a cell that is inside out
/// then have their last two nodes exchanged where they are to be `upright`.
std::vector<Tetrahedron> cutSixMirrored(const std::vector<Hexahedron>& cells, bool upright) {
  const auto places = gridPlaces(cells);
  if (!places)
    throw ComponentError("swapping needs hexahedra laid out like the cells of a grid",
                         "a regular grid, or cutting=\"five\" without swapping");
  constexpr int pairs[3][4][2] = {
      {{0, 1}, {3, 2}, {4, 5}, {7, 6}}, {{0, 3}, {1, 2}, {4, 7}, {5, 6}}, {{0, 4}, {1, 5}, {2, 6}, {3, 7}}};
  std::vector<Tetrahedron> out;
  out.reserve(6 * cells.size());
  for (std::size_t h = 0; h < cells.size(); ++h) {
    Hexahedron cell = cells[h];
    bool odd = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_odd_place = (*places)[h][axis] % 2 != 0;
      if (is_odd_place == (axis == 0)) continue;
      for (const auto& [a, b] : pairs[axis]) std::swap(cell[a], cell[b]);
      odd = !odd;
    }
    append(cell, odd && upright ? six_corners_odd : six_corners, out);
  }
  return out;
}

}  // namespace

int tetrahedraPerHexahedron(HexahedronCut cut) {
  if (cut == HexahedronCut::six || cut == HexahedronCut::mirrored) return 6;
  return cut == HexahedronCut::ten ? 10 : 5;
}

std::vector<Tetrahedron> cutHexahedra(const std::vector<Hexahedron>& hexahedra, HexahedronCut cut, bool mirrored) {
  if (cut == HexahedronCut::mirrored) return cutSixMirrored(hexahedra, false);
  if (mirrored && cut == HexahedronCut::six) return cutSixMirrored(hexahedra, true);
  if (mirrored) throw ComponentError("swapping mirrors the cutting into six tetrahedra only", "cutting=\"six\"");
  std::vector<Tetrahedron> out;
  out.reserve(hexahedra.size() * std::size_t(tetrahedraPerHexahedron(cut)));
  const std::vector<char> choice = cut == HexahedronCut::five ? alternate(hexahedra) : std::vector<char>{};
  for (std::size_t h = 0; h < hexahedra.size(); ++h) {
    if (cut == HexahedronCut::six) append(hexahedra[h], six_corners, out);
    const bool first = cut == HexahedronCut::five1 || cut == HexahedronCut::ten || (!choice.empty() && !choice[h]);
    const bool second = cut == HexahedronCut::five2 || cut == HexahedronCut::ten || (!choice.empty() && choice[h]);
    if (first) append(hexahedra[h], five1_corners, out);
    if (second) append(hexahedra[h], five2_corners, out);
  }
  return out;
}

Index mismatchedFaces(const std::vector<Hexahedron>& hexahedra, const std::vector<Tetrahedron>& tetrahedra,
                      int per_cell) {
  const auto has = [&](const CellFace& where, Index a, Index b) {
    const auto first = tetrahedra.begin() + std::ptrdiff_t(where.cell) * per_cell;
    return std::any_of(first, first + per_cell, [a, b](const Tetrahedron& t) {
      return std::count(t.begin(), t.end(), a) + std::count(t.begin(), t.end(), b) == 2;
    });
  };
  Index count = 0;
  for (const auto& [a, b] : sharedFaces(hexahedra)) {
    const FaceNodes n = nodesOf(hexahedra, a);
    count += has(a, n[0], n[2]) != has(b, n[0], n[2]) || has(a, n[1], n[3]) != has(b, n[1], n[3]);
  }
  return count;
}

std::optional<std::vector<std::array<int, 3>>> gridPlaces(const std::vector<Hexahedron>& hexahedra) {
  // Faces in the order -z, +z, -y, +x, +y, -x: the opposite face, the axis and the direction of the step across it.
  constexpr int opposite[6] = {1, 0, 4, 5, 2, 3}, axis[6] = {2, 2, 1, 0, 1, 0}, step[6] = {-1, 1, -1, 1, 1, -1};
  // The corner reached from a corner along each axis.
  constexpr int along[3][8] = {{1, 0, 3, 2, 5, 4, 7, 6}, {3, 2, 1, 0, 7, 6, 5, 4}, {4, 5, 6, 7, 0, 1, 2, 3}};
  std::vector<std::array<int, 3>> places(hexahedra.size(), {0, 0, 0});
  const bool fits = walk(
      hexahedra, [](Index) {},
      [&](const CellFace& from, const CellFace& to, bool is_new) {
        if (to.face != opposite[from.face]) return false;
        for (const int corner : faceOf(from.face))
          if (hexahedra[from.cell][corner] != hexahedra[to.cell][along[axis[from.face]][corner]]) return false;
        std::array<int, 3> place = places[from.cell];
        place[axis[from.face]] += step[from.face];
        if (is_new) places[to.cell] = place;
        return places[to.cell] == place;
      });
  if (!fits) return std::nullopt;
  return places;
}

}  // namespace stroma
