// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// Data that a solver keeps per matrix: factors, work space, the last solution. Looked up once per solve, usually among one
/// entry. Data of destroyed matrices is freed when the next new matrix arrives, or with the solver.
template <class Kept>
class PerMatrix {
 public:
  /// The data of this matrix, created by `make` (a std::unique_ptr<Kept>) on first use. Its address is stable as long as the
  /// matrix lives.
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
