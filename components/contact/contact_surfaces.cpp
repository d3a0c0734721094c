// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "framework/mesh/cell_lists.h"

namespace stroma::contact {

int Surfaces::addVertex(Index row, const Vec3& x) {
  rows.push_back(row);
  rest.push_back(x);
  body_.push_back(int(bodies_.size()) - 1);
  ++bodies_.back().vertices;
  return int(rows.size()) - 1;
}

void Surfaces::addState(const State& state, const Mesh& mesh) { addFaces(mesh, &state, state.rest_position); }
void Surfaces::addObstacle(const Mesh& mesh, const std::vector<Vec3>& position) { addFaces(mesh, nullptr, position); }

void Surfaces::addBalls(const State& state, const std::vector<double>& radii) {
  bodies_.push_back({.moves = true, .first_vertex = int(rows.size()), .first_face = int(faces.size())});
  for (Index node = 0; node < state.nodes(); ++node) {
    const int v = addVertex(state.firstRow() + node, state.rest_position[std::size_t(node)]);
    faces.push_back({v, v, v}), radius.push_back(radii[std::size_t(node)]);
  }
  bodies_.back().faces = int(faces.size()) - bodies_.back().first_face;
}

void Surfaces::addObstacles(const std::vector<Vec3>& centres, const std::vector<double>& radii) {
  for (std::size_t i = 0; i < centres.size(); ++i) addObstacle({centres[i]}, {{0, 0, 0}}, radii[i]);
}

/// Without a state they are an obstacle's.
void Surfaces::addFaces(const Mesh& mesh, const State* state, const std::vector<Vec3>& position) {
  bodies_.push_back({.moves = state != nullptr, .first_vertex = int(rows.size()), .first_face = int(faces.size())});
  std::map<Index, int> vertex_of;
  const auto vertex = [&](Index node) {
    const auto [at, is_new] = vertex_of.try_emplace(node, -1);
    if (is_new) at->second = addVertex(state ? state->firstRow() + node : -1, position[std::size_t(node)]);
    return at->second;
  };
  const auto add = [&](Index a, Index b, Index c) {
    const int i = vertex(a), j = vertex(b), k = vertex(c);
    faces.push_back({i, j, k});
  };
  const bool hollow = highestDimension(mesh) < 3;
  bodies_.back().solid = !hollow;
  for (const Triangle& t : hollow ? mesh.triangles : mesh.boundaryTriangles()) add(t[0], t[1], t[2]);
  for (const Quad& q : hollow ? mesh.quads : mesh.boundaryQuads()) {
    halves_.push_back(int(faces.size()));
    add(q[0], q[1], q[2]), add(q[0], q[2], q[3]);
  }
  for (const auto& [a, b, c, ab, bc, ca] : hollow ? mesh.quadratic_triangles : mesh.boundaryQuadraticTriangles())
    add(a, ab, ca), add(ab, b, bc), add(ca, bc, c), add(ab, bc, ca);
  const int dimension = highestDimension(mesh);
  for (std::size_t e = 0; dimension == 1 && e < mesh.edges.size(); ++e) add(mesh.edges[e][0], mesh.edges[e][0], mesh.edges[e][1]);
  for (Index node = 0; dimension == 0 && node < Index(mesh.position.size()); ++node) add(node, node, node);
  bodies_.back().faces = int(faces.size()) - bodies_.back().first_face;
  radius.resize(faces.size(), 0);
}

void Surfaces::addObstacle(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& of_points,
                           double r) {
  bodies_.push_back({.first_vertex = int(rows.size()), .first_face = int(faces.size())});
  const int first = int(rows.size());
  for (const Vec3& p : points) addVertex(-1, p);
  for (const auto& f : of_points) faces.push_back({first + f[0], first + f[1], first + f[2]});
  bodies_.back().faces = int(of_points.size());
  radius.resize(faces.size(), r);
}

void Surfaces::finish() {
  area.clear();
  for (const auto& [a, b, c] : faces) {
    const Vec3 &p = rest[std::size_t(a)], &q = rest[std::size_t(b)], &r = rest[std::size_t(c)];
    area.push_back(0.5 * (q - p).cross(r - p).norm());
  }
  findCorners();
  std::vector<std::vector<Index>> around(rows.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (auto& list = around[std::size_t(faces[f][k])]; list.empty() || list.back() != Index(f)) list.push_back(Index(f));
  faces_around = {};
  vertex_radius.assign(rows.size(), 0);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (const int v : faces[f]) vertex_radius[std::size_t(v)] = radius[f];
  for (const auto& list : around) {
    faces_around.values.insert(faces_around.values.end(), list.begin(), list.end());
    faces_around.start.push_back(Index(faces_around.values.size()));
  }
  findVertexAreas();
  findEdges();
  findMeanEdge();
  findOwners();
  findPieces();
  findSides();
}

void Surfaces::findVertexAreas() {
  vertex_area.assign(rows.size(), 0);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) vertex_area[std::size_t(faces[f][k])] += corner_area[f][k];
}

void Surfaces::giveWidth(double range, double thickness) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& [a, b, c] = faces[f];
    if (a != b || !moves(a)) continue;
    const int edge = face_edges[f][1];  // from b to c; -1: a point
    const double least = range + thickness, of_ball = 2 * M_PI * radius[f] * range, of_rod = 2 * std::sqrt(2 * radius[f] * range);
    area[f] = edge < 0 ? std::max(least * least, of_ball) : std::max(least, of_rod) * std::sqrt(edge_square[std::size_t(edge)]);
    corner_area[f] = edge < 0 ? std::array{area[f], 0., 0.} : std::array{area[f] / 2, 0., area[f] / 2};
    if (edge >= 0) edge_area[std::size_t(edge)] += area[f];
  }
  findVertexAreas();
}

/// A corner of a triangle has a third of it. A corner of a quad has the integral of its bilinear function, whichever way the quad is
/// cut: a sixth of the quad and of the triangle of that corner and its two neighbours, as if each diagonal cut half of it.
void Surfaces::findCorners() {
  corner_area.clear();
  for (const double whole : area) corner_area.push_back({whole / 3, whole / 3, whole / 3});
  for (const int half : halves_) {
    const std::size_t f = std::size_t(half), g = f + 1;  // (0, 1, 2) and (0, 2, 3)
    const auto at = [&](std::size_t face, std::size_t k) -> const Vec3& { return rest[std::size_t(faces[face][k])]; };
    const auto areaOf = [](const Vec3& p, const Vec3& q, const Vec3& r) { return 0.5 * (q - p).cross(r - p).norm(); };
    const double quad = area[f] + area[g], at_0 = areaOf(at(g, 2), at(f, 0), at(f, 1)), at_2 = areaOf(at(f, 1), at(f, 2), at(g, 2));
    if (!(quad > 0) || !(at_0 + at_2 > 0)) continue;
    const double of_0 = (quad + at_0 * quad / (at_0 + at_2)) / 6, of_2 = (quad + at_2 * quad / (at_0 + at_2)) / 6;
    for (const std::size_t half_of : {f, g}) {
      const double part = area[half_of] / quad;
      const bool is_first = half_of == f;
      corner_area[half_of] = {part * of_0, is_first ? (quad + area[f]) / 6 : part * of_2, is_first ? part * of_2 : (quad + area[g]) / 6};
    }
  }
}

/// Triangles that a person has written may turn any way: where they enclose no positive volume, both sides count.
void Surfaces::findSides() {
  one_sided_.assign(rows.size(), true);
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (disagree_[e] && !bodies_[std::size_t(bodyOf(edges[e][0]))].solid)
      one_sided_[std::size_t(pieceOf(edges[e][0]))] = false;
  std::vector<double> volume(rows.size(), 0);
  for (const auto& [a, b, c] : faces) {
    const Vec3& from = rest[std::size_t(pieceOf(a))];
    volume[std::size_t(pieceOf(a))] +=
        (rest[std::size_t(a)] - from).cross(rest[std::size_t(b)] - from).dot(rest[std::size_t(c)] - from);
  }
  for (std::size_t v = 0; v < rows.size(); ++v)
    if (!bodies_[std::size_t(body_[v])].solid && !(volume[v] > 0)) one_sided_[v] = false;
}

void Surfaces::findPieces() {
  piece_.resize(rows.size());
  std::iota(piece_.begin(), piece_.end(), 0);
  const auto root = [this](int v) {
    while (piece_[std::size_t(v)] != v) v = piece_[std::size_t(v)] = piece_[std::size_t(piece_[std::size_t(v)])];
    return v;
  };
  for (const auto& face : faces)
    for (const int v : face) piece_[std::size_t(root(v))] = root(face[0]);
  for (std::size_t v = 0; v < piece_.size(); ++v) piece_[v] = root(int(v));
}

void Surfaces::findEdges() {
  std::map<std::array<int, 2>, int> edge_of;
  std::vector<bool> forward;  // the first triangle of an edge has its ends in this order
  std::vector<int> triangles;  // of an edge
  face_edges.assign(faces.size(), {-1, -1, -1});
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = faces[f][k], b = faces[f][(k + 1) % 3], tip = faces[f][(k + 2) % 3];
      if (a == b) continue;
      const std::array<int, 2> key{std::min(a, b), std::max(a, b)};
      const auto [at, is_new] = edge_of.try_emplace(key, int(edges.size()));
      face_edges[f][k] = at->second;
      if (is_new) {
        edges.push_back(key);
        triangles.push_back(0);
        edge_tips.push_back({-1, -1});
        edge_area.push_back(0);
        disagree_.push_back(true);  // as long as it has one triangle
        forward.push_back(a < b);
        edge_square.push_back((rest[std::size_t(a)] - rest[std::size_t(b)]).squaredNorm());
      }
      const std::size_t e = std::size_t(at->second);
      if (tip == a || tip == b) continue;  // an edge alone
      if (!is_new) disagree_[e] = triangles[e] > 1 || forward[e] == (a < b);
      edge_tips[e][triangles[e] == 0 ? 0 : 1] = tip;
      ++triangles[e];
      edge_area[e] += area[f] / 3;
    }
  vertex_count.resize(rows.size());
  for (std::size_t v = 0; v < rows.size(); ++v) vertex_count[v] = 1 - int(faces_around.start[v + 1] - faces_around.start[v]);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    edge_surplus.push_back(std::max(0, triangles[e] - 1));
    for (const int v : edges[e]) vertex_count[std::size_t(v)] += edge_surplus[e];
  }
}

void Surfaces::findOwners() {
  std::vector<bool> has_vertex(rows.size(), false), has_edge(edges.size(), false);
  owned_vertices.assign(faces.size(), {-1, -1, -1});
  owned_edges = owned_vertices;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t v = std::size_t(faces[f][k]);
      if (!has_vertex[v]) owned_vertices[f][k] = int(v);
      has_vertex[v] = true;
      const int e = face_edges[f][k];
      if (e < 0 || has_edge[std::size_t(e)]) continue;
      owned_edges[f][k] = e;
      has_edge[std::size_t(e)] = true;
    }
}

void Surfaces::gather(ConstRows x, const Vec3& moved, std::vector<Vec3>& out) const {
  out.resize(rows.size());
  for (const Body& body : bodies_) {
    const std::size_t end = std::size_t(body.first_vertex + body.vertices);
    if (body.moves)
      for (std::size_t v = std::size_t(body.first_vertex); v < end; ++v) out[v] = x[rows[v]];
    else
      for (std::size_t v = std::size_t(body.first_vertex); v < end; ++v) out[v] = rest[v] + moved;
  }
}

void Surfaces::gatherWay(ConstRows dx, const Vec3& along, std::vector<Vec3>& out) const {
  out.resize(rows.size());
  for (const Body& body : bodies_) {
    const std::size_t end = std::size_t(body.first_vertex + body.vertices);
    for (std::size_t v = std::size_t(body.first_vertex); v < end; ++v) out[v] = body.moves ? Vec3(dx[rows[v]]) : along;
  }
}

void Surfaces::gatherBends(const double* bend, std::vector<double>& out) const {
  out.assign(bend ? rows.size() : 0, 0);
  for (std::size_t v = 0; v < out.size(); ++v)
    if (rows[v] >= 0) out[v] = bend[rows[v]];
}

bool Surfaces::areBodiesAt(const std::vector<Vec3>& x, const std::vector<Vec3>& other) const {
  constexpr int at_once = 96;  // numbers: what has moved is mostly seen in the first of them
  if (x.size() != other.size()) return false;
  for (const Body& body : bodies_) {
    if (!body.moves || body.vertices == 0) continue;
    const double *p = x[std::size_t(body.first_vertex)].data(), *q = other[std::size_t(body.first_vertex)].data();
    for (int begin = 0; begin < 3 * body.vertices; begin += at_once) {
      const int end = std::min(begin + at_once, 3 * body.vertices);
      long differ = 0;
#pragma omp simd reduction(+ : differ)
      for (int i = begin; i < end; ++i) differ += p[i] != q[i];
      if (differ > 0) return false;
    }
  }
  return true;
}

void Surfaces::findMeanEdge() {
  double sum = 0;
  int count = 0;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (moves(edges[e][0])) sum += std::sqrt(edge_square[e]), ++count;
  mean_edge_ = count > 0 ? sum / count : 0;
}

}  // namespace stroma::contact
