// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/actors.h"

namespace stroma {

/// The mappings of a system, from independent rows to all rows and back. Costs nothing in a system without mappings.
class MappingChain {
 public:
  /// Once states are bound and mappings compiled; `actors` outlives this.
  void compile(const Actors& actors);
  bool empty() const { return actors_->mappings.empty(); }
  bool isLinear() const { return linear_; }

  /// The same vector on all rows. Vectors of a caller end with the independent rows, or have rows for mapped states that
  /// only mappings can fill. Valid until the next call of the same function.
  ConstRows positions(ConstRows x) const;
  ConstRows velocities(ConstRows v) const { return lifted(v, v_, actors_->mappings); }
  ConstRows direction(ConstRows p) const { return lifted(p, p_, actors_->mappings); }
  /// The same for a product: mappings to what does not act now are left out until finishProduct().
  ConstRows beginProduct(ConstRows p) const;

  /// The acceleration of mapped rows where that of independent ones is zero, at the x of the last positions() and the v of
  /// all rows; zero in independent rows.
  void curve(ConstRows v, Rows a) const;

  /// Where to add forces on all rows for out += J^T f: `out` itself without mappings, else zeroed work space. To be passed
  /// to finishProduct().
  Rows beginSum(Rows out) const;
  /// out += J^T all of a product with `p` (on all rows), on independent rows; nothing to do without mappings. With k times the
  /// stiffness each mapping that is not linear adds the turning of the force on its child, (J^T f)' = J^T K J + dJ^T/dx f.
  void finishProduct(ConstRows p, double k, Rows all, Rows out) const;

  /// all += J^T all, from children to parents.
  void pullBack(Rows all) const;
  /// The force on all rows that geometric stiffnesses are taken with.
  void noteForce(ConstRows f);
  ConstRows lastForce() const { return last_force_; }

  /// Places mapped rows of positions and velocities that something acts on; placePassive() the others.
  void place(Rows x, Rows v) const;
  void placePassive(Rows x, Rows v) const;
  long passivePlacings() const { return passive_placings_; }  ///< how often they were placed

 private:
  ConstRows lifted(ConstRows p, Vector& work, const std::vector<Mapping*>& mappings) const;

  const Actors* actors_ = nullptr;
  std::vector<std::vector<const ForceField*>> loads_;  ///< of each mapping, on its child and what follows it; null: always
  mutable std::vector<Mapping*> acting_;               ///< of the product that has begun
  bool linear_ = true;
  mutable long passive_placings_ = 0;
  mutable Vector x_, v_, p_, f_;  ///< work space, shape (all rows), only with mappings
  Vector last_force_;             ///< shape (all rows), only with mappings that are not linear
};

}  // namespace stroma
