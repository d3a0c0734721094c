// SPDX-License-Identifier: LGPL-2.1-or-later
// The systems of a run, and stored x and v of each.
#pragma once
#include <memory>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

/// The systems of a simulation, in document order.
using Systems = std::vector<std::unique_ptr<System>>;

/// Brings nodes that integrators have deferred up to date.
void complete(const Systems& systems);

/// x and v of one system.
struct Snapshot {
  Vector x, v;
  explicit Snapshot(Index rows) : x(rows), v(rows) {}
  void take(const System& system) { copy(system.x, x), copy(system.v, v); }
  void putBack(System& system) const { copy(x, system.x), copy(v, system.v); }
};

/// The start of a run, and the last successful step.
class Snapshots {
 public:
  /// Makes the present state the start.
  void compile(const Systems& systems);

  const Snapshot& start(std::size_t system) const { return start_[system]; }
  const Snapshot& good(std::size_t system) const { return good_[system]; }
  Snapshot& good(std::size_t system) { return good_[system]; }

  void takeGood(const Systems& systems);
  /// For the first `count` systems.
  void putGoodBack(const Systems& systems, std::size_t count) const;
  void putStartBack(const Systems& systems) const;

 private:
  std::vector<Snapshot> start_, good_;
};

}  // namespace stroma
