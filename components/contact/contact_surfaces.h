// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "framework/mechanics/state.h"
#include "framework/mesh/mesh.h"

namespace stroma::contact {

/// The surfaces of all bodies of an interaction and of its obstacles, as one list of vertices, edges and triangles. A
/// triangle may repeat its first vertex: (a, a, b) is an edge, (a, a, a) a point. Obstacles have such, with a radius, and so have
/// bodies of edges or of points alone.
class Surfaces {
 public:
  struct Body {
    bool moves = false;  ///< its vertices are rows of a state, otherwise of an obstacle
    bool solid = false;  ///< the boundary of volume cells
    int first_vertex = 0, vertices = 0, first_face = 0, faces = 0;
  };

  void clear() { *this = {}; }
  /// Adds the boundary of the mesh's volume cells, or if it has none its faces, edges or points. A quad becomes two triangles, a
  /// quadratic triangle four.
  void addState(const State& state, const Mesh& mesh);
  /// Adds an obstacle; `radius`: of its rounded points and edges.
  void addObstacle(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& faces, double radius);
  /// Adds the surface of a mesh, chosen as in addState(), as an obstacle; `position`: of its nodes [m].
  void addObstacle(const Mesh& mesh, const std::vector<Vec3>& position);
  /// Adds a ball around each node of a state, or a point where its radius is 0 [m].
  void addBalls(const State& state, const std::vector<double>& radii);
  /// The same as obstacles, each of its own.
  void addObstacles(const std::vector<Vec3>& centres, const std::vector<double>& radii);
  /// Call it when all have been added.
  void finish();
  /// After that: edges without a triangle become strips that face what they meet, and points squares. They are as wide as `range` plus
  /// `thickness`. Rounded ones are, if that is wider, the part of their surface with a gap below `range` on a plane [m].
  void giveWidth(double range, double thickness);
  /// Positions of all vertices: rows of x, and obstacles moved by `moved`.
  void gather(ConstRows x, const Vec3& moved, std::vector<Vec3>& out) const;
  /// Displacements of all vertices: rows of dx, and `along` for obstacles.
  void gatherWay(ConstRows dx, const Vec3& along, std::vector<Vec3>& out) const;
  /// Values per row as values per vertex; 0 for obstacles. Empty if there are none.
  void gatherBends(const double* bend, std::vector<double>& out) const;
  /// Whether all vertices except those of obstacles are at the same positions as in `other`; false for a different number of them.
  bool areBodiesAt(const std::vector<Vec3>& x, const std::vector<Vec3>& other) const;

  const std::vector<Body>& bodies() const { return bodies_; }
  /// Vertices with the same number are connected by triangles.
  int pieceOf(int vertex) const { return piece_[std::size_t(vertex)]; }
  /// Only the outer side of this piece is solid: each of its edges has two triangles with consistent orientation.
  bool isOneSided(int vertex) const { return one_sided_[std::size_t(pieceOf(vertex))]; }
  int bodyOf(int vertex) const { return body_[std::size_t(vertex)]; }
  bool areExcluded(int body_a, int body_b) const {
    return std::find(excluded.begin(), excluded.end(), std::array{std::min(body_a, body_b), std::max(body_a, body_b)}) != excluded.end();
  }
  bool moves(int vertex) const { return rows[std::size_t(vertex)] >= 0; }
  bool sameEdge(int edge, int a, int b) const {
    return edges[std::size_t(edge)] == std::array{std::min(a, b), std::max(a, b)};
  }
  double meanEdge() const { return mean_edge_; }  ///< of bodies, at rest [m]

  std::vector<std::array<int, 2>> excluded;  ///< bodies without contact with each other, the smaller number first
  // ---- vertices ----
  std::vector<Index> rows;  ///< of the system; -1: of an obstacle
  std::vector<Vec3> rest;   ///< [m]
  std::vector<int> vertex_count;  ///< multiplicity of its own barrier, see contact_terms.h: 1 in the interior of a surface
  std::vector<double> vertex_radius;  ///< of its triangles, edges or ball [m]
  std::vector<double> vertex_area;  ///< sum of its corner areas [m^2]
  Adjacency faces_around;   ///< triangles of each vertex
  // ---- triangles ----
  std::vector<std::array<int, 3>> faces;
  std::vector<double> area;                                     ///< at rest [m^2]
  std::vector<std::array<double, 3>> corner_area;               ///< the share of each corner; they sum to `area` [m^2]
  std::vector<double> radius;                                   ///< [m]
  std::vector<std::array<int, 3>> face_edges;                   ///< edge from corner k to k + 1; -1: none
  std::vector<std::array<int, 3>> owned_vertices, owned_edges;  ///< each vertex and edge belongs to one triangle; -1
  // ---- edges ----
  std::vector<std::array<int, 2>> edges;       ///< smaller vertex first
  std::vector<int> edge_surplus;               ///< triangles beyond the first; 0: it has one or none
  std::vector<std::array<int, 2>> edge_tips;   ///< the third vertex of its first and of its last triangle; -1: none
  std::vector<double> edge_area;               ///< a third of these triangles [m^2]
  std::vector<double> edge_square;             ///< squared length at rest [m^2]

 private:
  int addVertex(Index row, const Vec3& x);
  void addFaces(const Mesh& mesh, const State* state, const std::vector<Vec3>& position);
  void findCorners();
  void findVertexAreas();
  void findEdges();
  void findMeanEdge();
  void findOwners();
  void findPieces();
  void findSides();

  std::vector<Body> bodies_;
  double mean_edge_ = 0;
  std::vector<int> halves_;        ///< first triangles of quads; the next triangle is the other half
  std::vector<int> body_, piece_;  ///< per vertex
  std::vector<bool> one_sided_;    ///< per piece, at its first vertex
  std::vector<bool> disagree_;     ///< per edge: it has one or three triangles, or their orientations differ
};

}  // namespace stroma::contact
