// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of tetrahedra with labels. Positions have 9 significant digits, less than the accuracy of any scanner.
#pragma once
#include <map>
#include <optional>
#include <string>

#include "tools/mesh/regions.h"

namespace stroma {

/// Names of labels; one without a name is called "label_3".
using LabelNames = std::map<int, std::string>;
std::string nameOf(int label, const LabelNames& names);

/// Gmsh .msh, ASCII, format 4.1 or 2.2. Each label is a physical group of tetrahedra with the label as its tag and its
/// name, each surface between two regions one of triangles, named "soft.bone" or "soft.outside". A hollow that the body
/// encloses is no part of the skin: its wall is "soft.cavity", of several "soft.cavity_1" (the largest),
/// "soft.cavity_2".
/// `order` 2: quadratic tetrahedra and triangles, with a node in the middle of each edge after all corners.
std::string gmshText(const LabelledMesh& mesh, const LabelNames& names, bool format_22, int order = 1);

/// The nodes of such a file that are no corners: one for each edge of the cells of a label, or of all.
Index countMiddles(const LabelledMesh& mesh, std::optional<int> label = {});

/// VTK's XML format .vtu: the tetrahedra with cell data `label`.
std::string vtuText(const LabelledMesh& mesh, int order = 1);

}  // namespace stroma
