// SPDX-License-Identifier: LGPL-2.1-or-later
// The examples of the manual pages, and the files that they read.
#pragma once
#include <filesystem>
#include <fstream>
#include <string>

namespace stroma::test {

/// The scene below the line `Example:`, or empty.
inline std::string exampleIn(const std::string& page) {
  const std::string mark = "\nExample:\n";
  const auto at = page.find(mark);
  if (at == std::string::npos) return {};
  const auto end = page.find("</Node>\n", page.rfind("</Node>"));
  return end == std::string::npos ? "" : page.substr(at + mark.size(), end + 8 - at - mark.size());
}

/// What the examples read: one tetrahedron, or its surface, in each format, and a recording.
inline void writeExampleFiles(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "block.msh") << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                                         "4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n";
  std::ofstream(folder / "block.vtk") << "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                         "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n"
                                         "CELL_TYPES 1\n10\n";
  std::ofstream(folder / "block.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::ofstream(folder / "fall.state") << "T= 0\n  X= 0 0 0 1 0 0\nT= 0.02\n  X= 0 -0.002 0 1 0.038 0\n";
  std::ofstream(folder / "block.stl") << "solid block\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\n"
                                         "vertex 1 0 0\nendloop\nendfacet\nendsolid block\n";
  std::ofstream(folder / "block.off") << "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  std::ofstream(folder / "block.trian") << "4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n4\n0 2 1 1 2 3\n0 1 3 0 2 3\n1 2 3 0 1 3\n0 3 2 0 1 2\n";
  std::ofstream(folder / "block.gid") << "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                                         "4 0 0 1\nEnd Coordinates\n\nElements\n1 1 2 3 4\nEnd Elements\n";
  std::ofstream(folder / "block.inp") << "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=BLOCK\n"
                                         "1, 1, 2, 3, 4\n*NSET, NSET=BASE\n1, 2, 3\n";
  std::ofstream(folder / "two.xs3") << "Xsp 3.0\nnumm 2\nnums 1\nmass 1 s 0 0 0 0 0 0 1 0\nmass 2 s 1 0 0 0 0 0 1 0\n"
                                       "lspg 1 1 2 10 1 1\n";
  std::ofstream(folder / "two.sph") << "sph 1.0\nsphe 0 0 0 0 0.1\nsphe 1 1 0 0 0.2\n";
  std::ofstream(folder / "two.raw") << "\1\1\1\1";
}

}  // namespace stroma::test
