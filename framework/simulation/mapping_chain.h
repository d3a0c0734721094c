// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/actors.h"

namespace stroma {

/// The mappings of a system, from independent rows to all rows and back. Costs nothing in a system without mappings.
class MappingChain {
 public:
  /// Call it when states are bound and mappings compiled; `actors` must outlive this object.
  void compile(const Actors& actors);
  bool empty() const { return actors_->mappings.empty(); }
  bool isLinear() const { return linear_; }

  /// The vector extended to all rows. The caller's vector has only independent rows, or also has rows of mapped states,
  /// which only mappings can fill. Valid until the next call of the same function.
  ConstRows positions(ConstRows x) const;
  ConstRows velocities(ConstRows v) const { return lifted(v, v_, actors_->mappings); }
  ConstRows direction(ConstRows p) const { return lifted(p, p_, actors_->mappings); }
  /// The same for a product: until finishProduct(), mappings onto inactive force fields are skipped.
  ConstRows beginProduct(ConstRows p) const;

  /// The acceleration of mapped rows if independent rows have none, at the x of the last positions() and the v of all rows;
  /// zero in independent rows.
  void curve(ConstRows v, Rows a) const;

  /// Where to add forces f on all rows for the sum out += J^T f: `out` itself without mappings, otherwise zeroed work space.
  /// Pass it to finishProduct().
  Rows beginSum(Rows out) const;
  /// out += J^T all, on independent rows, for a product with `p` (on all rows); no work without mappings. With k times the
  /// stiffness each nonlinear mapping adds its geometric stiffness: (J^T f)' = J^T K J + dJ^T/dx f.
  void finishProduct(ConstRows p, double k, Rows all, Rows out) const;

  /// all += J^T all, from children to parents.
  void pullBack(Rows all) const;
  /// The force on all rows that geometric stiffnesses use.
  void noteForce(ConstRows f);
  ConstRows lastForce() const { return last_force_; }

  /// Updates positions and velocities of mapped rows that something acts on; placePassive() updates the others.
  void place(Rows x, Rows v) const;
  void placePassive(Rows x, Rows v) const;
  long passivePlacings() const { return passive_placings_; }  ///< how often they were updated

 private:
  ConstRows lifted(ConstRows p, Vector& work, const std::vector<Mapping*>& mappings) const;

  const Actors* actors_ = nullptr;
  std::vector<std::vector<const ForceField*>> loads_;  ///< per mapping: fields on its child and on states mapped from it; null: always
  mutable std::vector<Mapping*> acting_;               ///< in the current product
  bool linear_ = true;
  mutable long passive_placings_ = 0;
  mutable Vector x_, v_, p_, f_;  ///< work space, shape (all rows), only with mappings
  Vector last_force_;             ///< shape (all rows), only with mappings that are not linear
};

}  // namespace stroma
