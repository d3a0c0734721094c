// SPDX-License-Identifier: LGPL-2.1-or-later
// Second Piola-Kirchhoff stresses that do not depend on the shape, one per point of each cell: what a viscous law
// remembers, or a prestress. Their forces f_a = -V_0 F H G_a are linear in the positions. The kernels live in the
// module of the laws, which is built for each instruction set; it offers them once.
#pragma once
#include <memory>
#include <vector>

#include "components/hyperelasticity/hyperelastic_law.h"

namespace stroma::hyperelastic {

/// Arranged in the same way as the elements of a law on the same cells: the slots of one serve the other.
class ResidualStress {
 public:
  virtual ~ResidualStress() = default;
  /// H [Pa] in the material's axes, shape (cells, points, 6): xx yy zz xy yz zx.
  virtual void hold(const std::vector<double>& stress) = 0;
  /// The forces of the last hold().
  virtual ElementKernels& forces() = 0;
  const ElementKernels& forces() const { return const_cast<ResidualStress&>(*this).forces(); }
  /// F in the material's axes, shape (cells, points, 9), by columns; x are the system's rows.
  virtual void deformations(ConstRows x, std::vector<double>& out) const = 0;
};

struct ResidualStressKernels {
  std::unique_ptr<ResidualStress> (*tetrahedra)(const Cells&) = nullptr;
  std::unique_ptr<ResidualStress> (*hexahedra)(const Cells&) = nullptr;
};
/// Empty until a module has offered them.
ResidualStressKernels& residualStressKernels();

}  // namespace stroma::hyperelastic
