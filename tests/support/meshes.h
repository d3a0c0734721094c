// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes for tests.
#pragma once
#include <random>

#include "components/topology/cell_cuts.h"
#include "framework/mesh/mesh.h"

namespace stroma::test {

/// nx x ny x nz unit hexahedra, nodes with x fastest.
inline Mesh gridMesh(int nx, int ny, int nz) {
  Mesh mesh;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) mesh.position.push_back(Vec3(i, j, k));
  const auto node = [&](int i, int j, int k) { return Index(i + (nx + 1) * (j + (ny + 1) * k)); };
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        mesh.hexahedra.push_back({node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k),
                                  node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
                                  node(i, j + 1, k + 1)});
  return mesh;
}

/// The grid's nodes, moved at random, and its hexahedra cut into tetrahedra.
inline Mesh tetrahedronMesh(int nx, int ny, int nz, HexahedronCut cut, double disorder = 0.15) {
  const Mesh grid = gridMesh(nx, ny, nz);
  Mesh mesh;
  mesh.position = grid.position;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(-disorder, disorder);
  for (Vec3& p : mesh.position) p += Vec3(offset(random), offset(random), offset(random));
  mesh.tetrahedra = cutHexahedra(grid.hexahedra, cut);
  return mesh;
}

}  // namespace stroma::test
