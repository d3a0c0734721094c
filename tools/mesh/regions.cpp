// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/regions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"
#include "framework/mesh/simplex_size.h"

namespace stroma {

namespace {

/// A face of a cell, by its sorted nodes.
struct Face {
  Triangle sorted, nodes;
  Index cell;
};

std::vector<Face> sortedFaces(const LabelledMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(cell_kinds::tetrahedron.faces.size() * mesh.tetrahedra.size());
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c)
    for (const LocalFace& local : cell_kinds::tetrahedron.faces) {
      Face face;
      for (std::size_t i = 0; i < 3; ++i) face.nodes[i] = mesh.tetrahedra[c][local.nodes[i]];
      face.sorted = face.nodes;
      std::sort(face.sorted.begin(), face.sorted.end());
      face.cell = Index(c);
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end(),
            [](const Face& a, const Face& b) { return std::tie(a.sorted, a.cell) < std::tie(b.sorted, b.cell); });
  return faces;
}

/// Calls visit(face of the first cell, the second cell or -1) for each face of the mesh.
template <class Visit>
void forEachFace(const LabelledMesh& mesh, Visit&& visit) {
  const std::vector<Face> faces = sortedFaces(mesh);
  for (std::size_t i = 0; i < faces.size();) {
    const bool shared = i + 1 < faces.size() && faces[i + 1].sorted == faces[i].sorted;
    visit(faces[i], shared ? faces[i + 1].cell : -1);
    i += shared ? 2 : 1;
  }
}

/// Sorts the edges of a region's boundary (directed; triangles turned outward) into closed, open and branching ones.
void judgeEdges(const LabelledMesh& mesh, std::vector<Edge> directed, RegionReport& region) {
  std::sort(directed.begin(), directed.end());
  const auto times = [&directed](const Edge& e) {
    const auto [first, last] = std::equal_range(directed.begin(), directed.end(), e);
    return last - first;
  };
  for (std::size_t i = 0; i < directed.size(); ++i) {
    const Edge& e = directed[i];
    if (i > 0 && e == directed[i - 1]) continue;
    const auto here = times(e), back = times({e[1], e[0]});
    if (here == 1 && back == 1) continue;
    if (here == back && e[0] > e[1]) continue;  // told by its other direction
    const bool first = here == back ? region.manifold() : region.watertight();
    if (first) region.place = (mesh.position[e[0]] + mesh.position[e[1]]) / 2;
    ++(here == back ? region.branching_edges : region.open_edges);
  }
}

Index rootOf(std::vector<Index>& parent, Index i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

void reportSurfaces(const LabelledMesh& mesh, std::map<int, RegionReport>& regions) {
  std::map<int, std::vector<Edge>> edges;
  std::vector<Index> parent(mesh.tetrahedra.size());
  std::iota(parent.begin(), parent.end(), 0);
  forEachFace(mesh, [&](const Face& face, Index other) {
    const int own = mesh.labels[face.cell], across = other < 0 ? 0 : mesh.labels[other];
    if (own == across) {
      parent[rootOf(parent, face.cell)] = rootOf(parent, other);
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = face.nodes[i], b = face.nodes[(i + 1) % 3];
      edges[own].push_back({a, b});
      if (across) edges[across].push_back({b, a});
    }
  });
  for (auto& [label, directed] : edges) judgeEdges(mesh, std::move(directed), regions[label]);
  for (std::size_t c = 0; c < parent.size(); ++c)
    if (parent[c] == Index(c)) ++regions[mesh.labels[c]].parts;
}

/// Of the tetrahedron between the origin and a triangle: their sum over a closed surface is the volume inside, negative
/// where the surface is turned inward.
double signedVolume(const LabelledMesh& mesh, const Triangle& t) {
  return mesh.position[t[0]].dot(mesh.position[t[1]].cross(mesh.position[t[2]])) / 6;
}

/// The closed surfaces of which the boundary to the outside consists. Triangles are turned out of the material, so the wall
/// of a hollow encloses a negative volume.
void numberCavities(const LabelledMesh& mesh, std::vector<RegionTriangle>& triangles) {
  std::vector<std::size_t> outer;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (triangles[t].outside == 0) outer.push_back(t);
  std::vector<Index> parent(outer.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::map<Edge, Index> first_with;
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const Triangle& nodes = triangles[outer[i]].nodes;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(nodes[k], nodes[(k + 1) % 3]);
      const auto [other, is_new] = first_with.try_emplace(Edge{low, high}, Index(i));
      if (!is_new) parent[rootOf(parent, Index(i))] = rootOf(parent, other->second);
    }
  }
  std::map<Index, double> volume;  // by root
  for (std::size_t i = 0; i < outer.size(); ++i)
    volume[rootOf(parent, Index(i))] += signedVolume(mesh, triangles[outer[i]].nodes);
  std::vector<std::pair<double, Index>> hollows;
  for (const auto& [root, enclosed] : volume)
    if (enclosed < 0) hollows.emplace_back(enclosed, root);
  std::sort(hollows.begin(), hollows.end());
  for (std::size_t i = 0; i < outer.size(); ++i)
    for (std::size_t c = 0; c < hollows.size(); ++c)
      if (hollows[c].second == rootOf(parent, Index(i))) triangles[outer[i]].cavity = int(c) + 1;
}

}  // namespace

std::array<double, 2> dihedralAngles(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> p{a, b, c, d};
  std::array<Vec3, 4> normal;  // outward, of the face opposite each corner
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& n = cell_kinds::tetrahedron.faces[f].nodes;
    normal[f] = (p[n[1]] - p[n[0]]).cross(p[n[2]] - p[n[0]]);
  }
  std::array<double, 2> range{180, 0};
  for (const auto& [i, j] : cell_kinds::tetrahedron.edges) {
    const Vec3 &m = normal[i], &n = normal[j];
    const double angle = 180 - std::atan2(m.cross(n).norm(), m.dot(n)) * (180 / std::numbers::pi);
    range = {std::min(range[0], angle), std::max(range[1], angle)};
  }
  return range;
}

std::vector<RegionTriangle> regionTriangles(const LabelledMesh& mesh) {
  std::vector<RegionTriangle> triangles;
  forEachFace(mesh, [&](const Face& face, Index other) {
    const int own = mesh.labels[face.cell], across = other < 0 ? 0 : mesh.labels[other];
    if (own == across) return;
    if (across == 0 || own < across)
      triangles.push_back({face.nodes, own, across, 0});
    else
      triangles.push_back({{face.nodes[0], face.nodes[2], face.nodes[1]}, across, own, 0});
  });
  numberCavities(mesh, triangles);
  std::stable_sort(triangles.begin(), triangles.end(), [](const RegionTriangle& a, const RegionTriangle& b) {
    return std::tuple(a.outside != 0, a.inside, a.outside, a.cavity) <
           std::tuple(b.outside != 0, b.inside, b.outside, b.cavity);
  });
  return triangles;
}

MeshQuality qualityOf(const LabelledMesh& mesh) {
  MeshQuality quality;
  std::map<int, RegionReport> regions;
  std::map<int, std::set<Index>> nodes;
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c) {
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = mesh.position[mesh.tetrahedra[c][i]];
    RegionReport& region = regions[mesh.labels[c]];
    ++region.tetrahedra;
    region.volume += tetrahedronVolume(p[0], p[1], p[2], p[3]);
    nodes[mesh.labels[c]].insert(mesh.tetrahedra[c].begin(), mesh.tetrahedra[c].end());
    const auto [small, large] = dihedralAngles(p[0], p[1], p[2], p[3]);
    if (small < quality.smallest_angle) quality.smallest_angle = small, quality.worst = Index(c);
    quality.largest_angle = std::max(quality.largest_angle, large);
  }
  reportSurfaces(mesh, regions);
  for (auto& [label, region] : regions) {
    region.label = label;
    region.nodes = Index(nodes[label].size());
    quality.regions.push_back(region);
  }
  return quality;
}

}  // namespace stroma
