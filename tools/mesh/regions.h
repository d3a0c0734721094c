// SPDX-License-Identifier: LGPL-2.1-or-later
// A tetrahedral mesh whose cells have labels: the surfaces between its regions, and what a person wants to know of it.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// Tetrahedra of positive volume, each with its label (> 0). Every node is used.
struct LabelledMesh {
  std::vector<Vec3> position;
  std::vector<Tetrahedron> tetrahedra;
  std::vector<int> labels;  ///< of each tetrahedron
};

/// A triangle between two regions, or between a region and the outside (label 0).
struct RegionTriangle {
  Triangle nodes;  ///< counter-clockwise seen from outside of `inside`
  int inside = 0;  ///< the smaller label that is not 0
  int outside = 0;
  int cavity = 0;  ///< of triangles to the outside: 0 on the skin, from 1 on in a hollow that the body encloses
};

/// All of them, by (outside is 0 or not, inside, outside, cavity), then by their nodes. Cavities are numbered from the
/// largest down.
std::vector<RegionTriangle> regionTriangles(const LabelledMesh& mesh);

/// One label of a mesh.
struct RegionReport {
  int label = 0;
  Index tetrahedra = 0, nodes = 0;
  double volume = 0;          ///< sum of its cells
  Index open_edges = 0;       ///< of its boundary: triangles on one side only, or turned against each other
  Index branching_edges = 0;  ///< closed, but more than two triangles meet
  Vec3 place = Vec3::Zero();  ///< the middle of the first of these edges, an open one if there is any
  Index parts = 0;            ///< connected through faces
  bool watertight() const { return open_edges == 0; }
  bool manifold() const { return open_edges == 0 && branching_edges == 0; }
};

struct MeshQuality {
  std::vector<RegionReport> regions;               ///< by label, ascending
  double smallest_angle = 180, largest_angle = 0;  ///< dihedral angles of all cells [degrees]
  Index worst = -1;                                ///< the cell with the smallest one
};

MeshQuality qualityOf(const LabelledMesh& mesh);

/// Smallest and largest of the six dihedral angles of a tetrahedron [degrees].
std::array<double, 2> dihedralAngles(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// How far matchVolumes() came, and what held its last step back.
struct VolumeMatch {
  double error = 0;          ///< the largest relative error of a volume that is left
  Index at_reach = 0;        ///< nodes that stand where the share of their shortest edge ends
  Index held_by_angles = 0;  ///< nodes that went less far because a dihedral angle would have become too small
};

/// Moves the nodes on the boundaries between regions, each along its area vector, so that the regions get the volumes
/// `wanted` (by label; labels without an entry are left as they are). Nodes inside of regions stay. Inscribed
/// triangles make a round body too small by a part that depends on their size; this gives it back. A node moves at most
/// 0.3 of its shortest edge, and no further than leaves every dihedral angle at `least_angle` [degrees] or where it
/// was.
VolumeMatch matchVolumes(LabelledMesh& mesh, const std::map<int, double>& wanted, double least_angle);

}  // namespace stroma
