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
  double step = 0;       ///< of hexahedra along it: how long they are along the body, over the thickness; 0: unknown
  /// How far end faces of these hexahedra lean to and fro, seen from the side and from above: t, where the end faces of one cell lean
  /// apart by the tangent t each and those of the next toward each other. Root of the mean square of half the differences of neighbours.
  double lean = 0, lean_in_plan = 0;
  /// Long beside its thickness, so that it bends. A cube is not, nor are most organs.
  bool isSlender() const { return typical > 0 && typical < 0.3 * extent; }
};
/// Of the hexahedra, or of the tetrahedra. Nothing (not slender) for meshes above 100,000 cells, which are seldom coarse.
/// `held`: an axis along which no node can move, as in plane strain: nothing bends there, and lines along it do not count.
Slenderness slenderness(const std::vector<Hexahedron>& cells, const std::vector<Vec3>& position,
                        const Vec3& held = Vec3::Zero());
Slenderness slenderness(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& position,
                        const Vec3& held = Vec3::Zero());

/// What a law says of a change of volume.
struct BendingLaw {
  double poisson_ratio = 0.3;
  bool has_mean_dilatation = false;
  bool has_incompatible_modes = false;  ///< cells that bend by themselves
  bool may_have_them = false;           ///< where it has none
};
/// A sentence where linear cells of a slender body make it more than 3 % too stiff in bending, or empty. Edges of hexahedra stay
/// straight: over a cell of length a a curvature k adds the shear k s, s from its middle. Its energy over that of bending is
/// G a^2 / (E h^2), however many cells lie over the thickness h. A volume change at each point adds about 1.1 nu^2/(1 - 2 nu) / n^2
/// with n cells over it. Of tetrahedra the error is about 3 / n^2.
/// End faces that lean to and fro by the tangents t, seen from the side, and p, seen from above, add 3 (t^2 + G/E p^2) a^2/h^2: the energy
/// of the mean strain that the corners of such a cell have in bending. No cell that passes the patch test avoids it (MacNeal 1987), and
/// with incompatible modes it is all that is left. Where neighbours lean alike, as in a curved beam, the nodes move so that it vanishes.
std::string tooCoarseForBending(const Slenderness& body, bool hexahedra, const BendingLaw& law = {});

/// Whether a field's volume change is one per cell or around nodes.
bool hasMeanDilatation(const ForceField& field);
/// Whether its cells have incompatible modes, so that their corners alone do not say how they are strained.
bool hasIncompatibleModes(const ForceField& field);

/// The kind of cells that a force field has a law for, with a stress in each; null: it has none.
const CellKind* kindOfLaw(const ForceField& field);

/// A note with that sentence for each elastic force field of such a body.
void noteCoarseCells(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
