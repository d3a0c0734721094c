// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces on small groups of nodes (a node, the two ends of a spring, a triangle): products, assembly and diagonals of
// their derivatives. A component evaluates energy and force, and stores one tangent per group.
#pragma once
#include <algorithm>
#include <array>
#include <type_traits>
#include <vector>

#include "framework/mechanics/force_field.h"

namespace stroma {

/// The derivative of the forces of N nodes, with one block per pair of nodes.
template <int N>
struct DenseTangent {
  std::array<Mat3, std::size_t(N) * N> blocks;  ///< row-major
  void setZero() { blocks.fill(Mat3::Zero()); }
  Mat3 block(int i, int j) const { return blocks[std::size_t(i * N + j)]; }
  Mat3& block(int i, int j) { return blocks[std::size_t(i * N + j)]; }
  void addProduct(const std::array<Index, std::size_t(N)>& rows, ConstRows dx, double factor, Rows df) const {
    for (int i = 0; i < N; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int j = 0; j < N; ++j) sum += block(i, j) * dx[rows[j]];
      df[rows[i]] += factor * sum;
    }
  }
};

/// The same for two nodes with opposite forces that depend only on their difference: k = df_i/dx_i.
struct PairTangent {
  Mat3 k;
  void setZero() { k.setZero(); }
  Mat3 block(int i, int j) const { return i == j ? k : Mat3(-k); }
  void addProduct(const std::array<Index, 2>& rows, ConstRows dx, double factor, Rows df) const {
    const Vec3 force = factor * (k * (dx[rows[0]] - dx[rows[1]]));
    df[rows[0]] += force;
    df[rows[1]] -= force;
  }
};

/// Base of force fields on groups of N nodes. Derived classes call setGroups() or setNodes() in compile() and write stiffness_ (and
/// damping_ if requested) in addForce(). If a tangent costs more than the force, addForce() calls outdateTangents()
/// instead, and computeTangents() writes stiffness_ on demand: explicit steps never ask for it.
template <int N, class Tangent = DenseTangent<N>>
class NodeGroupField : public ForceField {
 public:
  /// Rows of the system of one group; a group may name a row twice.
  using Group = std::array<Index, std::size_t(N)>;

  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    addProduct(stiffness(), dx, factor, df);
  }
  void addDampingProduct(ConstRows dv, double factor, Rows df) const override { addProduct(damping_, dv, factor, df); }
  void addPattern(BlockPattern& pattern) const override {
    for (const Group& group : rows_) pattern.addClique(group.data(), N);
  }
  void prepareAssembly(const BlockMatrix& matrix) override {
    slots_.clear();
    for (const Group& group : rows_)
      for (Index row : group)
        for (Index column : group) slots_.push_back(matrix.slot(row, column));
  }
  void addStiffness(double factor, BlockMatrix& matrix) const override { addTo(stiffness(), factor, matrix); }
  /// Measured for 1 to 8 nodes: a block takes 2 ns in products and 3 ns in assembly from the caches, and twice that once tangents fill
  /// 20 MB. A pair multiplies once. Some groups have fewer than N nodes, so up to 64 of them are sampled.
  Cost cost() const override {
    constexpr std::size_t most_read = 64;
    const std::size_t each = 1 + stiffness_.size() / most_read;
    double sum = 0, read = 0;
    for (std::size_t g = 0; g < stiffness_.size(); g += each) sum += nodesOf(stiffness_[g]) * nodesOf(stiffness_[g]), ++read;
    const double tangents = double(stiffness_.size() + damping_.size()), megabytes = 1e-6 * sizeof(Tangent) * tangents;
    const double blocks = std::max(1.0, sum / std::max(1.0, read) * tangents);  // zero would mean: not known
    const double times = 1 + std::clamp((megabytes - 4) / 16, 0.0, 1.0), product = std::is_same_v<Tangent, PairTangent> ? 0.9 : 2;
    return {product * times * blocks, 3 * times * blocks};
  }
  void addDamping(double factor, BlockMatrix& matrix) const override { addTo(damping_, factor, matrix); }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    addDiagonal(stiffness(), factor, blocks);
  }
  void addDampingDiagonal(double factor, std::vector<double>& blocks) const override {
    addDiagonal(damping_, factor, blocks);
  }

 protected:
  /// `rows`: rows of the system. Tangents start at zero.
  void setGroups(std::vector<Group> rows, bool damped) {
    rows_ = std::move(rows);
    stiffness_.resize(rows_.size());
    for (Tangent& tangent : stiffness_) tangent.setZero();
    damping_.resize(damped ? rows_.size() : 0);
    for (Tangent& tangent : damping_) tangent.setZero();
  }

  /// One group for each of these nodes of the state.
  void setNodes(const std::vector<Index>& nodes, bool damped) requires(N == 1) {
    std::vector<Group> rows;
    rows.reserve(nodes.size());
    for (Index node : nodes) rows.push_back({state().firstRow() + node});
    setGroups(std::move(rows), damped);
  }

  void outdateTangents() { tangents_outdated_ = true; }
  /// Writes stiffness_ at the positions of the last addForce().
  virtual void computeTangents() const {}

  std::vector<Group> rows_;                 ///< shape (groups)
  mutable std::vector<Tangent> stiffness_;  ///< df/dx [N/m], shape (groups)
  std::vector<Tangent> damping_;            ///< df/dv [N s/m], shape (groups) or empty

 private:
  const std::vector<Tangent>& stiffness() const {
    if (tangents_outdated_) computeTangents();
    tangents_outdated_ = false;
    return stiffness_;
  }
  /// N, or less if the tangent says so: the rest of its group then repeats a row.
  static int nodesOf(const Tangent& tangent) {
    if constexpr (requires { tangent.corners; }) return tangent.corners;
    return N;
  }
  /// out += factor * sum of the tangents times p, group by group.
  void addProduct(const std::vector<Tangent>& tangents, ConstRows p, double factor, Rows out) const {
    for (std::size_t g = 0; g < tangents.size(); ++g) tangents[g].addProduct(rows_[g], p, factor, out);
  }
  /// Blocks of all groups into the matrix that prepareAssembly() looked up.
  void addTo(const std::vector<Tangent>& tangents, double factor, BlockMatrix& matrix) const {
    for (std::size_t g = 0; g < tangents.size(); ++g)
      for (int i = 0; i < nodesOf(tangents[g]); ++i)
        for (int j = 0; j < nodesOf(tangents[g]); ++j)
          matrix.add(slots_[(g * N + std::size_t(i)) * N + std::size_t(j)], factor * tangents[g].block(i, j));
  }
  void addDiagonal(const std::vector<Tangent>& tangents, double factor, std::vector<double>& blocks) const {
    for (std::size_t g = 0; g < tangents.size(); ++g)
      for (int i = 0; i < nodesOf(tangents[g]); ++i) {
        const Mat3 block = tangents[g].block(i, i);
        double* out = blocks.data() + std::size_t(rows_[g][i]) * 9;
        for (int k = 0; k < 9; ++k) out[k] += factor * block(k / 3, k % 3);
      }
  }

  std::vector<Index> slots_;  ///< shape (groups, N, N)
  mutable bool tangents_outdated_ = false;
};

}  // namespace stroma
