// SPDX-License-Identifier: LGPL-2.1-or-later
// The one element loop: gather nodes to packs, call the element's mathematics, scatter; energies; assembly. A force
// field supplies pure functions of packs and never sees a node number, a thread or a matrix slot. The bodies are
// flattened: all of an element's mathematics is inlined, so that packs live in registers.
#pragma once
#include <array>

#include "framework/algebra/block_matrix.h"
#include "framework/algebra/parallel.h"
#include "framework/fem/arrangement.h"
#include "framework/fem/pack.h"

namespace stroma {

/// Meshes with fewer elements run on one thread: waking another costs more than it saves.
constexpr Index parallelElements(int nodes) { return 4 * blockElements(nodes); }

/// Which nodes of an element have a block in its matrix: all pairs, unless an element says otherwise.
struct EveryPair {
  static constexpr bool coupled(int, int) { return true; }
};

/// The loop over elements of N nodes. Node numbers are rows of the system.
template <int N, class Coupling = EveryPair>
class ElementLoop {
 public:
  /// One value per node and lane: positions [m], velocities, forces.
  using Nodes = V3<Pack>[N];

  /// `cells` index `position` (shape (nodes)); `first_row` is added to give rows of the system.
  void build(const std::vector<std::array<Index, N>>& cells, const std::vector<Vec3>& position, Index first_row) {
    arrangement_ = arrangeElements(cells.empty() ? nullptr : cells[0].data(), N, Index(cells.size()), position, pack_lanes);
    partial_.assign(arrangement_.block_start.size() - 1, 0.);
    offsets_.resize(std::size_t(arrangement_.batches) * N * pack_lanes);
    for (Index b = 0; b < arrangement_.batches; ++b)
      for (int l = 0; l < pack_lanes; ++l) {
        // a padding lane repeats the nodes of lane 0: it stays inside the block and, having no stiffness, adds zero
        const Index e = elementOf(b, l) >= 0 ? elementOf(b, l) : elementOf(b, 0);
        for (int a = 0; a < N; ++a)
          offsets_[(std::size_t(b) * N + a) * pack_lanes + l] = (cells[e][a] + first_row) * row_doubles;
      }
  }
  /// Batches hold pack_lanes elements each; the last of a block may have padding.
  Index batches() const { return arrangement_.batches; }
  Index elements() const { return arrangement_.elements; }
  /// The element in lane l of a batch, -1 for padding.
  Index elementOf(Index batch, int lane) const { return arrangement_.element[std::size_t(batch) * pack_lanes + lane]; }

  /// kernel(batch, in, out): in[i][a] is node a of input i, out[o][a] starts undefined and is added to output o.
  template <int In, int Out, class Kernel>
  void run(const std::array<ConstRows, In>& input, const std::array<Rows, Out>& output, Kernel&& kernel) const {
    forEachBatch([&](Index b) __attribute__((flatten)) {
      Nodes in[In > 0 ? In : 1], out[Out > 0 ? Out : 1];
      for (int i = 0; i < In; ++i) gather(b, input[i], in[i]);
      kernel(b, in, out);
      for (int o = 0; o < Out; ++o) scatter(b, out[o], output[o]);
    });
  }

  /// The nodes of one batch.
  void gather(Index batch, ConstRows x, Nodes& out) const {
#pragma GCC unroll 8  // else the packs go through memory
    for (int a = 0; a < N; ++a) out[a] = gatherRows(x.data, offset(batch, a));
  }

  /// Sum over elements of kernel(batch, nodes of x), a pack; blocks are summed in their order.
  template <class Kernel>
  double sum(ConstRows x, Kernel&& kernel) const {
    forEachBlock([&](Index block, Index first, Index last) __attribute__((flatten)) {
      Pack total(0.);
      for (Index b = first; b < last; ++b) {
        Nodes in;
        gather(b, x, in);
        total += kernel(b, in);
      }
      alignas(64) double lane[pack_lanes];
      total.store_aligned(lane);
      double& partial = partial_[block];
      partial = 0;
      for (double value : lane) partial += value;
    });
    double result = 0;
    for (double value : partial_) result += value;
    return result;
  }

  // ---- assembly ----

  /// Marks the coupled pairs of nodes of every element, padding left out.
  void addPattern(BlockPattern& pattern) const {
    forEachBatch([&](Index b) {  // blocks that run at once have different rows
      for (int at = 0; at < N * N * pack_lanes; ++at)
        if (const int l = at / (N * N), i = at / N % N, j = at % N; elementOf(b, l) >= 0 && Coupling::coupled(i, j))
          pattern.addBlock(row(b, i, l), row(b, j, l));
    });
  }
  /// Looks up the slots of every pair of nodes, shape (batches, N, N, lanes); 0 for pairs that are not coupled.
  std::vector<Index> slots(const BlockMatrix& matrix) const {
    std::vector<Index> result(std::size_t(batches()) * N * N * pack_lanes, 0);
    forEachBatch([&](Index b) {
      for (int at = 0; at < N * N * pack_lanes; ++at)
        if (const int ij = at / pack_lanes, l = at % pack_lanes; elementOf(b, l) >= 0 && Coupling::coupled(ij / N, ij % N))
          result[std::size_t(b) * N * N * pack_lanes + std::size_t(at)] = matrix.slot(row(b, ij / N, l), row(b, ij % N, l));
    });
    return result;
  }
  /// K of the elements of one batch, [i][j][row][column]; what is not coupled is not read.
  using Matrix = Pack[N * N * 9];

  /// How many slots() are.
  std::size_t slotCount() const { return std::size_t(batches()) * N * N * pack_lanes; }
  /// values (of the matrix the slots belong to) += factor * K, K from matrix(batch, out); `slots`: as from slots().
  template <class ElementMatrix>
  void assemble(double factor, const Index* slots, std::vector<double>& values, ElementMatrix&& matrix) const {
    forEachBatch([&](Index b) __attribute__((flatten)) {
      Matrix k;
      matrix(b, k);
      int lanes = 0;
      while (lanes < pack_lanes && elementOf(b, lanes) >= 0) ++lanes;
      for (int ij = 0; ij < N * N; ++ij)
        if (Coupling::coupled(ij / N, ij % N))
          addToBlocks(k + ij * 9, Pack(factor), slots + (std::size_t(b) * N * N + std::size_t(ij)) * pack_lanes, lanes, values.data());
    });
  }
  /// blocks[row] += factor * diagonal blocks of K, shape (rows, 9), K from matrix(batch, out).
  template <class ElementMatrix>
  void assembleDiagonal(double factor, std::vector<double>& blocks, ElementMatrix&& matrix) const {
    addDiagonal(factor, blocks, [&](Index b, Diagonal& out) {
      Matrix k;
      matrix(b, k);
      for (int a = 0; a < N; ++a) std::copy_n(k + (a * N + a) * 9, 9, out + a * 9);
    });
  }
  /// The diagonal blocks alone, [node][row][column].
  using Diagonal = Pack[N * 9];
  /// The same from diagonal(batch, out).
  template <class ElementDiagonal>
  void addDiagonal(double factor, std::vector<double>& blocks, ElementDiagonal&& diagonal) const {
    forEachBatch([&](Index b) __attribute__((flatten)) {
      Diagonal k;
      diagonal(b, k);
      alignas(64) double element[N * 9][pack_lanes];
      for (int i = 0; i < N * 9; ++i) (k[i] * Pack(factor)).store_aligned(element[i]);
      for (int l = 0; l < pack_lanes; ++l) {
        if (elementOf(b, l) < 0) break;
        for (int a = 0; a < N; ++a)
          for (int i = 0; i < 9; ++i) blocks[std::size_t(row(b, a, l)) * 9 + std::size_t(i)] += element[a * 9 + i][l];
      }
    });
  }
  /// K column by column, from node `first` on: product(dx, df) with unit vectors.
  template <class Product>
  static void matrixFromProducts(Product&& product, Matrix& matrix, int first = 0) {
    for (int j = first; j < N; ++j)
      for (int column = 0; column < 3; ++column) {
        Nodes dx{}, df;
        (column == 0 ? dx[j].x : column == 1 ? dx[j].y : dx[j].z) = Pack(1.);
        product(dx, df);
        for (int i = 0; i < N; ++i) {
          Pack* block = matrix + (i * N + j) * 9;
          block[column] = df[i].x, block[3 + column] = df[i].y, block[6 + column] = df[i].z;
        }
      }
  }

  /// Runs body(batch) for all batches, blocks of one colour at a time on the threads.
  template <class Body>
  void forEachBatch(Body&& body) const {
    forEachTile<1>([&](Index batch, Index) { body(batch); });
  }
  /// Runs body(first batch, batches) for tiles of at most `size` batches, for loops that take several at once; order as above.
  template <Index size, class Body>
  void forEachTile(Body&& body) const {
    forEachBlock([&](Index, Index first, Index last) {
      for (Index b = first; b < last; b += size) body(b, std::min(size, last - b));
    });
  }
  /// Runs body(batch, lane) for all elements, on one thread.
  template <class Body>
  void forEachLane(Body&& body) const {
    for (Index b = 0; b < batches(); ++b)
      for (int l = 0; l < pack_lanes && elementOf(b, l) >= 0; ++l) body(b, l);
  }

  /// output[node] += values, lane after lane: lanes of one batch may share nodes, concurrent batches may not.
  void scatter(Index batch, const Nodes& values, Rows output) const {
#pragma GCC unroll 8
    for (int a = 0; a < N; ++a) addToRows(values[a], offset(batch, a), output.data);
  }

 private:
  /// Where node a of each lane lies in the numbers of a vector, shape (lanes).
  const Index* offset(Index batch, int a) const {
    return offsets_.data() + (std::size_t(batch) * N + std::size_t(a)) * pack_lanes;
  }
  Index row(Index batch, int a, int lane) const { return offset(batch, a)[lane] / row_doubles; }

  /// body(block, first batch, last batch). Blocks of one colour touch no common node: they run at once, colours one after the
  /// other. Every node is added to in the same order whatever the number of threads.
  template <class Body>
  void forEachBlock(Body&& body) const {
    const auto& colour_start = arrangement_.colour_start;
    for (std::size_t c = 0; c + 1 < colour_start.size(); ++c) {
      const Index first = colour_start[c], count = colour_start[c + 1] - first;
      const auto run = [&](Index b) { body(first + b, arrangement_.block_start[first + b], arrangement_.block_start[first + b + 1]); };
      if (elements() < parallelElements(N))
        for (Index block = 0; block < count; ++block) run(block);
      else
        parallelFor(count, [&](int block) { run(block); });
    }
  }

  /// Order of the elements in batches, blocks and colours (arrangement.h).
  Arrangement arrangement_;
  mutable std::vector<double> partial_;  ///< scratch of sum(), shape (blocks)
  Array<Index> offsets_;                 ///< rows times row_doubles, shape (batches, N, lanes)
};

}  // namespace stroma
