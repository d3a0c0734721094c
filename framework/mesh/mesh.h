// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// A compressed list of lists: entries of item i are values[start[i]] ... values[start[i + 1] - 1].
struct Adjacency {
  std::vector<Index> start{0}, values;
  Index size() const { return Index(start.size()) - 1; }
};

/// The result of a mesh check. Volumes in m^3 (the mesh's unit cubed).
struct MeshReport {
  Index nodes = 0, edges = 0, triangles = 0, quads = 0, quadratic_triangles = 0;
  Index tetrahedra = 0, hexahedra = 0, prisms = 0, pyramids = 0, quadratic_tetrahedra = 0;
  double volume = 0;         ///< sum of the signed volumes of the volume cells, over `overlap`
  double overlap = 1;        ///< Mesh::overlap
  double worst_quality = 1;  ///< smallest mean-ratio quality of a volume cell: 1 regular, 0 flat, < 0 inverted
  Index worst_cell = -1;  ///< its index in the order of the lists of cells, -1 when there is none
  std::vector<Index> inverted;                   ///< volume cells with a negative volume
  std::vector<Index> flat;                       ///< volume cells with a volume below 1e-12 of their longest edge cubed
  std::vector<Index> unused_nodes;               ///< nodes that no cell uses
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< bounding box
  std::string text() const;                      ///< one line
};

/// Positions and cells. Tables derived from the cells are built when first asked for and kept.
class Mesh {
 public:
  std::vector<Vec3> position;  ///< [m], shape (nodes)
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::vector<Quad> quads;
  std::vector<QuadraticTriangle> quadratic_triangles;
  std::vector<Tetrahedron> tetrahedra;  ///< positive volume: (b-a) x (c-a) . (d-a) > 0
  std::vector<Hexahedron> hexahedra;    ///< VTK order: bottom face counter-clockwise, then the top face
  std::vector<Prism> prisms;            ///< the same of two triangles
  std::vector<Pyramid> pyramids;        ///< bottom face counter-clockwise seen from the top, then the top
  std::vector<QuadraticTetrahedron> quadratic_tetrahedra;  ///< corners as a tetrahedron's, then the edges' nodes
  /// How many times the volume cells cover the body: 2 for the superposition of two cuttings (ten tetrahedra a
  /// hexahedron), else 1. Masses and elastic force fields divide each cell's contribution by it.
  double overlap = 1;

  Index nodes() const { return Index(position.size()); }
  /// The first problem that makes the mesh unusable (an index out of range, a repeated node in a cell, a position
  /// that is not finite) as a sentence, or empty.
  std::string firstError() const;
  MeshReport report() const;

  // ---- derived on demand ----
  const std::vector<Edge>& allEdges() const;                                 ///< unique edges of all cells, sorted
  const std::vector<Triangle>& triangularFaces() const;                      ///< unique triangles of volume cells
  const std::vector<Triangle>& boundaryTriangles() const;                    ///< those of one volume cell only, outward
  const std::vector<Quad>& boundaryQuads() const;                            ///< quads of one volume cell only, outward
  const std::vector<QuadraticTriangle>& boundaryQuadraticTriangles() const;  ///< of one quadratic tetrahedron only
  const Adjacency& nodesAroundNode() const;  ///< by edges of cells, without itself, ascending
  /// How many derived tables have been built: a scene that needs none pays for none.
  int derivedTables() const;

 private:
  mutable std::optional<std::vector<Edge>> all_edges_;
  mutable std::optional<std::vector<Triangle>> triangular_faces_, boundary_triangles_;
  mutable std::optional<std::vector<Quad>> boundary_quads_;
  mutable std::optional<std::vector<QuadraticTriangle>> boundary_quadratic_triangles_;
  mutable std::optional<Adjacency> nodes_around_node_;
};

}  // namespace stroma
