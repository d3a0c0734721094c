// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/algebra/vector.h"

namespace stroma {

/// The part of a matrix that resists changes of volume: A = A' + sum_c w_c b_c b_c^T. Each term c has one pressure; b_c is the
/// gradient [m^2] of its volume with respect to the rows of the system. Bodies with one pressure per cell or node have such terms.
struct VolumeTerms {
  std::vector<Index> start{0}, rows;  ///< the rows of b_c; shape (terms + 1), (entries)
  std::vector<Vec3> gradients;        ///< b_c at these rows, shape (entries)
  std::vector<double> bulk, shear;    ///< w_c, from the bulk modulus, and the same from the shear modulus; shape (terms)

  Index count() const { return Index(bulk.size()); }
  /// Ends the term whose rows and gradients have been appended.
  void finish(double bulk_stiffness, double shear_stiffness) {
    start.push_back(Index(rows.size()));
    bulk.push_back(bulk_stiffness), shear.push_back(shear_stiffness);
  }
};

/// A force field whose stiffness -df/dx has such a part, at the state of the last force.
class ResistsVolumes {
 public:
  virtual ~ResistsVolumes() = default;
  virtual void addVolumeTerms(VolumeTerms& terms) const = 0;
};

/// A SystemMatrix that knows its part itself, with constraints eliminated.
class HasVolumeTerms {
 public:
  virtual ~HasVolumeTerms() = default;
  virtual VolumeTerms volumeTerms() const = 0;
};

}  // namespace stroma
