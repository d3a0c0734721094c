// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// What a solver keeps for each matrix: factors, work space, a last solution. Looked up once per solve,
/// usually in a list of one. The entry of a destroyed matrix is freed when the next new one comes, at
/// the latest with the solver.
template <class Kept>
class PerMatrix {
 public:
  /// What is kept for this matrix, made by `make` (a std::unique_ptr<Kept>) when it comes for the first time. Stays where
  /// it is as long as the matrix lives.
  template <class Make>
  Kept& of(const SystemMatrix& matrix, Make&& make) {
    const void* identity = matrix.identity().get();
    for (const Entry& entry : entries_)
      if (entry.identity == identity) return *entry.kept;
    std::erase_if(entries_, [](const Entry& entry) { return entry.life.expired(); });
    entries_.push_back({identity, matrix.identity(), make()});
    return *entries_.back().kept;
  }
  Kept& of(const SystemMatrix& matrix) {
    return of(matrix, [] { return std::make_unique<Kept>(); });
  }
  /// visit(Kept&) for every matrix.
  template <class Visit>
  void forEach(Visit&& visit) {
    for (Entry& entry : entries_) visit(*entry.kept);
  }
  std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    const void* identity;
    std::weak_ptr<const int> life;  ///< as long as it is held, no other identity can have this address
    std::unique_ptr<Kept> kept;
  };
  std::vector<Entry> entries_;
};

}  // namespace stroma
