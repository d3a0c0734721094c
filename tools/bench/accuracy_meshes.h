// SPDX-License-Identifier: LGPL-2.1-or-later
// The meshes of the standing set's problems, as overrides of their scenes. `cells`: across the body.
#pragma once
#include <string>
#include <vector>

namespace stroma::bench {

std::vector<std::string> beamMesh(int cells);
std::vector<std::string> cubeMesh(int cells);
std::vector<std::string> barMesh(int cells);
std::vector<std::string> blockMesh(int cells);
std::vector<std::string> columnMesh(int cells);
/// n x n cells of a plate, one across its thickness.
std::vector<std::string> cookMesh(int n);
/// n cells through the wall of an eighth of a thick ball, and n x n on each of three patches.
std::vector<std::string> chamberMesh(int n);
/// The same of a quarter of an ellipsoid without its top.
std::vector<std::string> ventricleMesh(int n);
/// 10 n x n x n cells.
std::vector<std::string> muscleMesh(int n);
std::vector<std::string> memoryMesh(int n);
/// That of the scene.
std::vector<std::string> ownMesh(int);

}  // namespace stroma::bench
