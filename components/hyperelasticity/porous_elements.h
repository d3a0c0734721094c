// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "components/hyperelasticity/porous_cells.h"
#include "components/hyperelasticity/porous_sponge.h"
#include "framework/algebra/block_matrix.h"

namespace stroma::porous {

/// Where the tangent is that of fluid which stays in each element.
struct OwnFluid {
  bool products = false, matrices = false;
};

/// The elements of a sponge, of whatever kind. What belongs to nodes (pressures, shares of a volume) is the x of a row;
/// rows are the system's. V_e is a cell's volume at rest, V_ea the share of node a in it.
class PorousElements {
 public:
  virtual ~PorousElements() = default;
  virtual void addPattern(BlockPattern& pattern) const = 0;
  virtual std::vector<Index> slots(const BlockMatrix& matrix) const = 0;

  /// Forces at x under the pressures of nodes.
  virtual void addForce(ConstRows x, ConstRows pressure, OwnFluid own_fluid, Rows f) = 0;
  virtual ConstRows positions() const = 0;  ///< of the last force
  /// theta_a += sum_e alpha V_ea ln J_e
  virtual void addVolumes(ConstRows x, Rows theta) const = 0;
  /// theta_a += sum_e alpha w_e^1/2 dV_e V_ea/V_e for nodes that move by dx from the x of the last force,
  /// w_e = d ln J/dJ.
  virtual void addVolumeChanges(ConstRows dx, Rows theta) const = 0;
  /// f += factor times the forces of alpha w_e^1/2 times the pressures of nodes, at the x of the last force.
  virtual void addPressureForces(ConstRows pressure, double factor, Rows f) const = 0;
  /// The potential of sigma_H, and of pressures that do not change, above the rest shape.
  virtual double energy(ConstRows x, ConstRows pressure) const = 0;

  /// The tangent of the elements alone, at the x of the last force.
  virtual void addProduct(ConstRows dx, double factor, Rows df) const = 0;
  virtual void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const = 0;
  virtual void assembleDiagonal(double factor, std::vector<double>& blocks) const = 0;
  struct Cost {
    double product, assembly;  ///< of a cell [ns]
  };
  virtual Cost cost() const = 0;
};

}  // namespace stroma::porous
