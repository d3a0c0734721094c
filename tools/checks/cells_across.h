// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma {

/// Over how many cells a body is thick where it is slender. From faces all over the boundary a line goes inward: through
/// opposite faces of hexahedra, straight along the normal through tetrahedra.
struct Slenderness {
  double typical = 0;    ///< median length of these lines [m]
  double extent = 0;     ///< longest side of the box around the cells [m]
  double thickness = 0;  ///< length of a thin one among the lines that are short beside the extent [m]: of a wall
  double cells = 0;      ///< number of cells along it
  /// Long beside its thickness, so that it bends. A cube is not, nor are most organs.
  bool isSlender() const { return typical > 0 && typical < 0.3 * extent; }
};
/// Of the hexahedra, or of the tetrahedra. Nothing (not slender) for meshes above 100,000 cells, which are seldom coarse.
/// `held`: an axis along which no node can move, as in plane strain: nothing bends there, and lines along it do not count.
Slenderness slenderness(const std::vector<Hexahedron>& cells, const std::vector<Vec3>& position,
                        const Vec3& held = Vec3::Zero());
Slenderness slenderness(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& position,
                        const Vec3& held = Vec3::Zero());

/// A sentence where linear cells over the thickness of a slender body are so few that it is more than 3 % too stiff in
/// bending, or empty. Straight edges add a shear to bending: the error is about share / n^2 with n cells.
std::string tooCoarseForBending(const Slenderness& body, bool hexahedra);

/// The kind of cells that a force field has a law for, with a stress in each; null: it has none.
const CellKind* kindOfLaw(const ForceField& field);

/// A note with that sentence for each elastic force field of such a body.
void noteCoarseCells(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
