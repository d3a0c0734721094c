// SPDX-License-Identifier: LGPL-2.1-or-later
// How far cells are from the body that they stand for, from the deformed shape alone: strains that jump between cells are not
// those of a body.
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// With the strain E of the cells and a continuous one E* made of it, integrated over the cells [m^3].
struct StrainError {
  double error = 0, strain = 0;       ///< |E* - E|^2 and |E|^2
  double continuous = 0, common = 0;  ///< |E*|^2 and E* . E
  double largest = 0;                 ///< |E|^2 of the point that is strained most
  /// The estimated share of the work of loads that the mesh withholds: so much too stiff is it where loads are given, 1 - U_h/U. Loads do
  /// the same work on E as on the body's own strain, (E_body, E) = |E|^2. A coarse mesh shows the shape of that, not its size: with
  /// E_body = c E*, c from that equation, U_h/U is the squared cosine of the angle between E and E*.
  double share() const {
    if (!(strain > 0)) return 0;
    return continuous > 0 ? std::max(0., 1 - common / strain * (common / continuous)) : 1;
  }
};

/// What stands for tr(E): near Poisson's ratio 1/2 only that which the law resists tells how much.
struct VolumeChange {
  enum class Of { green, stretch, displacement, volume } of = Of::green;  ///< tr(E), tr(U) - 3, tr(F) - 3, J - 1
  bool is_mean = false;                                                   ///< each cell has one, its mean
};

/// Of Green's strain, whatever the law: |E|^2 = |dev E|^2 + `bulk` tr(E)^2, with K/(2 mu) for `bulk`, or 0. It is compared
/// with a continuous one, whose values at nodes are those of a linear fit to the cells around it (Zienkiewicz and Zhu
/// 1992), of quadratic cells a quadratic one. `modulus`: a weight per cell, empty: 1. Fits hold cells of one modulus only: between
/// materials strains do jump. Of tetrahedra, hexahedra, prisms, pyramids, quadratic tetrahedra and triangles.
template <class Cell>
StrainError strainError(const std::vector<Cell>& cells, const std::vector<Vec3>& rest, const std::vector<Vec3>& now,
                        const std::vector<double>& modulus = {}, double bulk = 0, VolumeChange change = {});

/// Of the cells of a field that stores elastic energy; nothing for other fields, inverted cells and shapes that
/// are as at rest.
std::optional<StrainError> meshErrorOf(const ForceField& field, ConstRows x);

/// A sentence for each system whose shapes are more than 3 % too stiff by that, fields weighted by their energy.
std::vector<std::string> meshErrors(const Simulation& simulation);

}  // namespace stroma
