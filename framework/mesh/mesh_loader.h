// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>

#include "framework/mesh/cell_lists.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// Base of the mesh loaders: attributes, transform, sub-elements, check and report. A loader of a format overrides
/// read() only. The outputs carry the names that topologies use, so that `src="@loader"` connects them all.
class MeshLoader : public MeshSource {
 public:
  void declare(DataTable& table) override;
  void init() override;
  /// Positions [m] and cells after the transform; valid after init().
  const Mesh& mesh() const { return mesh_; }

 protected:
  /// Fills `mesh` from the file. Throws ComponentError with a sentence; an empty mesh is reported by the caller.
  virtual void read(const std::string& file, Mesh& mesh) = 0;

  /// For formats whose files hold vectors: the attributes directionArray, tetrahedraDirections, hexahedraDirections and
  /// nodeDirections.
  void declareDirections(DataTable& table);

  /// For formats whose cells have a whole number: the attributes tetrahedraGroups and its like. `word`: what it is.
  void declareGroups(DataTable& table, const std::string& word);

  /// Vectors of the file under the name `array`, as many per cell or node as the array has: one, two or three.
  struct Directions {
    std::string array;
    PerCellList<std::vector<Vec3>> cells;
    std::vector<Vec3> nodes;
  };
  Directions directions_;
  PerCellList<std::vector<int>> groups_;  ///< a whole number of each cell, or empty lists
  bool create_subelements_ = false;

 private:
  void removeUnusedNodes();
  void transform();
  void flipFaces();
  void splitQuads();

  FileName filename_;
  std::string unit_;
  Mesh mesh_;
  bool flip_normals_ = false, triangulate_ = false, only_attached_points_ = false, points_only_ = false;
  Vec3 translation_ = Vec3::Zero(), rotation_ = Vec3::Zero(), scale3d_ = Vec3::Ones();
  double scale_ = 1;
  std::array<double, 16> transformation_{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};

/// Rotation by Euler angles [degrees]: about x, then y, then z, all fixed axes (R = Rz Ry Rx, as SOFA's).
Mat3 rotationFromDegrees(const Vec3& angles);

/// Adds the faces of the volume cells to the triangles and quads, and the edges of all cells to the edges, each after
/// those that are there and only when missing.
void addSubelements(Mesh& mesh);

/// Warnings about a mesh (inverted or flat cells, unused nodes, no volume) with the report of its check;
/// empty if there are none.
std::string meshComplaint(const Mesh& mesh);

}  // namespace stroma
