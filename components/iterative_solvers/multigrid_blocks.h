// SPDX-License-Identifier: LGPL-2.1-or-later
// Matrices of small blocks in single precision, as the levels of a multigrid hierarchy keep them, and products with a
// row of them. A block is stored column after column: a product is one multiply-add of registers for each column. Loads
// run past the end of a short column; what the lanes beyond the last row then hold is not used. Inline for the reason
// given in vector.h.
#pragma once
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "framework/algebra/memory.h"
#include "framework/algebra/parallel.h"
#include "framework/scene/types.h"

namespace stroma::amg {

/// Unknowns of a node of a coarse level: a rigid body's motion.
constexpr int modes = 6;

/// Numbers that a row of D unknowns fills in a vector; those beyond D are zero.
template <int D>
constexpr int lanes = D <= 4 ? 4 : 8;

template <int Count>
struct Register;
template <>
struct Register<4> {
  typedef float Lanes __attribute__((vector_size(16)));
};
template <>
struct Register<8> {
  typedef float Lanes __attribute__((vector_size(32)));
};

/// Memory that is not cleared before it is filled.
template <class T, class Memory>
struct NotCleared : Memory {
  template <class U>
  struct rebind {
    using other = NotCleared<U, typename std::allocator_traits<Memory>::template rebind_alloc<U>>;
  };
  NotCleared() = default;
  template <class U, class Other>
  NotCleared(const NotCleared<U, Other>&) {}
  template <class U>
  void construct(U*) {}
  template <class U>
  void construct(U* place, const U& value) {
    *place = value;
  }
};
/// Of arrays that are swept often: on huge pages.
template <class T>
using Uncleared = NotCleared<T, ArrayAllocator<T>>;
/// Of arrays that are read a few times and freed: in small pages, which the system has at hand.
template <class T>
using Passing = NotCleared<T, std::allocator<T>>;
using Floats = std::vector<float, Uncleared<float>>;

/// A column of D floats in a register.
template <int D>
struct Column {
  using Lanes = typename Register<lanes<D>>::Lanes;
  Lanes lane{};
  void load(const float* from) { std::memcpy(&lane, from, sizeof(Lanes)); }
  /// With zeros beyond D.
  void store(float* to) const {
    Lanes cut = lane;
    for (int l = D; l < lanes<D>; ++l) cut[l] = 0;
    std::memcpy(to, &cut, sizeof(Lanes));
  }
};

/// `count` floats to be filled, and eight zeros.
inline void allocate(Floats& values, std::size_t count) {
  values = {};
  values.resize(count + 8);
  std::fill_n(values.end() - 8, 8, 0.0f);
}

/// Rows of blocks of R x C floats.
template <int R, int C>
struct Blocks {
  static constexpr std::size_t size = std::size_t(R) * C;
  std::vector<Index> start{0}, columns;  ///< shape (rows + 1), (blocks)
  Floats values;                         ///< shape (blocks, C, R), and a few zeros for loads past the end

  Index rows() const { return Index(start.size()) - 1; }
  Index blocks() const { return Index(columns.size()); }
  /// Makes room for the blocks that `columns` has; they are to be filled.
  void allocateValues() { allocate(values, columns.size() * size); }
  float* at(Index slot) { return values.data() + std::size_t(slot) * size; }
  const float* at(Index slot) const { return values.data() + std::size_t(slot) * size; }

  /// sum = row `row` of A x.
  void multiplyRow(Index row, const float* __restrict x, Column<R>& sum) const {
    Column<R> part[C], column;
    for (Index s = start[std::size_t(row)]; s < start[std::size_t(row) + 1]; ++s) {
      const float* __restrict block = at(s);
      const float* __restrict p = x + std::size_t(columns[std::size_t(s)]) * lanes<C>;
      for (int c = 0; c < C; ++c) {
        column.load(block + c * R);
        part[c].lane += column.lane * p[c];
      }
    }
    sum = part[0];
    for (int c = 1; c < C; ++c) sum.lane += part[c].lane;
  }
};

/// body(row) for all rows, in pieces that threads share. Rows do not see each other.
template <class Body>
void forRows(Index rows, Body&& body) {
  constexpr Index piece = 1024;
  parallelFor(int((rows + piece - 1) / piece), [&](int k) {
    const Index end = std::min(rows, (Index(k) + 1) * piece);
    for (Index row = Index(k) * piece; row < end; ++row) body(row);
  });
}

}  // namespace stroma::amg
