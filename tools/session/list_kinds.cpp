// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/list_kinds.h"

#include <string_view>

namespace stroma {
namespace {

/// Attributes that number nodes.
constexpr std::string_view of_nodes[] = {"indices",
                                         "points",
                                         "nodes",
                                         "DOFsX",
                                         "DOFsV",
                                         "indices1",
                                         "indices2",
                                         "external_points",
                                         "requiredPoints",
                                         "drainedIndices",
                                         "meshIndices",
                                         "firstObjectPoints",
                                         "secondObjectPoints",
                                         "springsIndices1",
                                         "springsIndices2",
                                         "surfaceIndices",
                                         "first_point",
                                         "second_point",
                                         "curve",
                                         "indexPairs",
                                         "rigidIndexPerPoint",
                                         "repartition"};
/// Lists of whole numbers that number nothing of a mesh.
constexpr std::string_view of_nothing[] = {"coordinates",    "polynomialDegree", "densityOfBeams",
                                           "numEdgesCollis", "nbRef",            "excludedPairs"};

/// Whole numbers that name one node each.
constexpr std::string_view of_one_node[] = {"sliding_point", "axis_1", "axis_2", "plateNode", "object2_dof_index"};
/// Of what a mapping has last among those that it maps from: one node, or the ends of a range.
constexpr std::string_view of_one_mapped[] = {"index", "indexInput2", "baseIndex", "first", "last"};

}  // namespace

std::string linkOf(const std::string& type, const std::string& attribute) {
  if (type.starts_with("Attach") || type.starts_with("Spring") || type.starts_with("Bilateral") ||
      type.starts_with("LinearRelation")) {
    if (attribute == "indices1" || attribute == "springsIndices1") return "object1";
    if (attribute == "indices2" || attribute == "springsIndices2") return "object2";
  }
  if (type.ends_with("LagrangianConstraint")) {
    if (attribute == "first_point" || attribute == "sliding_point") return "object1";
    if (attribute == "second_point" || attribute == "axis_1" || attribute == "axis_2" || attribute == "curve") return "object2";
    if (attribute == "index") return "mstate";
  }
  if (attribute == "plateNode") return "plate";
  if (attribute == "object2_dof_index") return "object2";
  if (type == "WriteState" || type == "Monitor") return "mstate";
  return attribute == "external_points" || attribute == "secondObjectPoints" ? "external_rest_shape" : "";
}

bool namesOneNode(const std::string& type, const std::string& attribute) {
  return isIn(attribute, of_one_node) || (attribute == "index" && type.ends_with("LagrangianConstraint"));
}

bool namesOneMapped(const std::string& type, const std::string& attribute) {
  return type.ends_with("Mapping") && isIn(attribute, of_one_mapped);
}

ListKind kindOf(std::string attribute) {
  if (isIn(attribute, of_nodes)) return ListKind::nodes;
  if (isIn(attribute, of_nothing)) return ListKind::nothing;
  if (!attribute.empty() && attribute.back() >= '1' && attribute.back() <= '9') attribute.pop_back();  // of one part of several
  if (attribute == "listSegment" || attribute == "edgeIndices" || attribute == "edgeList") return ListKind::edges;
  if (attribute == "triangleList" || attribute == "triangleIndices" || attribute == "surfaceTriangles") return ListKind::triangles;
  if (attribute == "quadraticTriangleIndices") return ListKind::quadratic_triangles;
  if (attribute == "quadList" || attribute == "quadIndices") return ListKind::quads;
  if (attribute == "tetrahedronIndices") return ListKind::tetrahedra;
  return attribute == "hexahedronIndices" ? ListKind::hexahedra : ListKind::unknown;
}

const ListOrigins* originsOf(const MeshEdit& edit, ListKind kind) {
  const PerCellList<ListOrigins>& cells = edit.cells();
  switch (kind) {
    case ListKind::nodes: return &edit.points();
    case ListKind::edges: return &cells.edges;
    case ListKind::triangles: return &cells.triangles;
    case ListKind::quads: return &cells.quads;
    case ListKind::quadratic_triangles: return &cells.quadratic_triangles;
    case ListKind::tetrahedra: return &cells.tetrahedra;
    case ListKind::hexahedra: return &cells.hexahedra;
    case ListKind::nothing:
    case ListKind::unknown: break;
  }
  return nullptr;
}

}  // namespace stroma
