// SPDX-License-Identifier: LGPL-2.1-or-later
// The table of kinds of cells against VTK's own cells: numbers, order of nodes, shape functions, edges and faces.
#include <gtest/gtest.h>
#include <vtkCell.h>
#include <vtkGenericCell.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

#include <set>

#include "tests/support/cell_kind_names.h"

namespace stroma::test {
namespace {

class VtkCellKinds : public testing::TestWithParam<const CellKind*> {
 protected:
  void SetUp() override {
    cell_->SetCellType(kind_.vtk.number);
    ASSERT_EQ(cell_->GetNumberOfPoints(), kind_.nodes);
    for (int k = 0; k < kind_.nodes; ++k) cell_->GetPointIds()->SetId(k, kind_.vtk.order[k]);
  }
  /// The sorted numbers of our nodes in a part of VTK's cell.
  static std::set<int> nodesOf(vtkCell& part) {
    std::set<int> nodes;
    for (vtkIdType k = 0; k < part.GetNumberOfPoints(); ++k) nodes.insert(int(part.GetPointId(int(k))));
    return nodes;
  }
  /// VTK's reference cells go from 0 to 1; its pyramid is a hexahedron whose upper face is one point, its place at the corner.
  LocalPoint toVtk(const LocalPoint& xi) const {
    LocalPoint out = xi;
    if (kind_.type == CellType::prism) return {xi[0], xi[1], (1 + xi[2]) / 2};
    if (kind_.type == CellType::pyramid) {
      const double s = 1 - xi[2];
      return s == 0 ? LocalPoint{0, 0, 1} : LocalPoint{(1 + xi[0] / s) / 2, (1 + xi[1] / s) / 2, xi[2]};
    }
    if (kind_.reference[0][0] < 0)
      for (int i = 0; i < kind_.dimension; ++i) out[i] = (1 + xi[i]) / 2;
    return out;
  }

  const CellKind& kind_ = *GetParam();
  vtkSmartPointer<vtkGenericCell> cell_ = vtkSmartPointer<vtkGenericCell>::New();
};

TEST_P(VtkCellKinds, NodesAndShapesAreVtks) {
  EXPECT_EQ(cell_->GetCellDimension(), kind_.dimension);
  const double* places = cell_->GetParametricCoords();
  for (int k = 0; k < kind_.nodes; ++k) {
    const LocalPoint ours = toVtk(kind_.reference[kind_.vtk.order[k]]);
    for (int i = 0; i < kind_.dimension; ++i) EXPECT_EQ(places[3 * k + i], ours[i]) << k << " " << i;
  }
  for (const QuadratureRule& rule : kind_.rules)
    for (const QuadraturePoint& point : rule.points) {
      std::array<double, most_cell_nodes> ours{}, vtks{};
      kind_.shapes(point.xi, ours.data());
      const LocalPoint at = toVtk(point.xi);
      cell_->InterpolateFunctions(at.data(), vtks.data());
      for (int k = 0; k < kind_.nodes; ++k) EXPECT_NEAR(vtks[k], ours[kind_.vtk.order[k]], 1e-15);
    }
}

TEST_P(VtkCellKinds, EdgesAndFacesAreVtks) {
  std::set<std::set<int>> ours, vtks;
  if (kind_.order == 1)
    for (const auto& [a, b] : kind_.edges) ours.insert({a, b});
  else  // halves, one after the other
    for (std::size_t e = 0; e < kind_.edges.size(); e += 2)
      ours.insert({kind_.edges[e][0], kind_.edges[e][1], kind_.edges[e + 1][1]});
  if (kind_.dimension < 2) return;  // VTK's edges are those of faces and volumes
  for (int e = 0; e < cell_->GetNumberOfEdges(); ++e) vtks.insert(nodesOf(*cell_->GetEdge(e)));
  EXPECT_EQ(ours, vtks);
  ASSERT_EQ(std::size_t(cell_->GetNumberOfFaces()), kind_.faces.size());
  for (const LocalFace& face : kind_.faces) {
    const CellKind& of_face = kindOf(face.type);
    const std::set<int> nodes(face.nodes.begin(), face.nodes.end());
    bool found = false;
    for (int f = 0; f < cell_->GetNumberOfFaces(); ++f)
      found = found || (nodesOf(*cell_->GetFace(f)) == nodes && cell_->GetFace(f)->GetCellType() == of_face.vtk.number);
    EXPECT_TRUE(found);
  }
}

INSTANTIATE_TEST_SUITE_P(All, VtkCellKinds, testing::ValuesIn(cell_kinds::all),
                         [](const auto& kind) { return std::string(kind.param->singular); });

}  // namespace
}  // namespace stroma::test
