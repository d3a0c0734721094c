// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/dense_coupling.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

namespace stroma::porous {

struct DenseCoupling::Matrices {
  Eigen::MatrixXd root;   ///< Y = A^-1/2 U, shape (nodes, 3 nodes): K_fluid = -Y^T Y
  Eigen::MatrixXd fluid;  ///< -K_fluid, its lower triangle, shape (3 nodes, 3 nodes)
  bool multiplied = false;
};

DenseCoupling::DenseCoupling(const Mesh& mesh, const std::vector<Vec3>& rest, const Sponge& sponge, Index first_row)
    : mesh_(mesh), rest_(rest), sponge_(sponge), first_row_(first_row), matrices_(std::make_unique<Matrices>()) {}
DenseCoupling::~DenseCoupling() = default;

void DenseCoupling::addPattern(BlockPattern& pattern) const {
  std::vector<Index> rows(rest_.size());
  std::iota(rows.begin(), rows.end(), first_row_);
  pattern.addClique(rows.data(), int(rows.size()));
}

std::vector<Index> DenseCoupling::slots(const BlockMatrix& matrix) const {
  const Index n = Index(rest_.size());
  std::vector<Index> slots;
  slots.reserve(rest_.size() * rest_.size());
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) slots.push_back(matrix.slot(first_row_ + i, first_row_ + j));
  return slots;
}

void DenseCoupling::update(ConstRows x, const DarcyFlow& flow) {
  Matrices& m = *matrices_;
  const auto n = Eigen::Index(rest_.size());
  m.root.setZero(n, 3 * n);
  for (const Tetrahedron& cell : mesh_.tetrahedra) {
    Mat3 now, rest;
    for (int i = 0; i < 3; ++i) {
      now.col(i) = x[first_row_ + cell[i + 1]] - x[first_row_ + cell[0]];
      rest.col(i) = rest_[cell[i + 1]] - rest_[cell[0]];
    }
    const double six_volumes = rest.determinant();
    const double weight = std::sqrt(sponge_.logarithmSlope(now.determinant() / six_volumes));
    const double factor = std::copysign(weight / (24 * mesh_.overlap), six_volumes);
    Eigen::Matrix<double, 3, 4> area;
    for (int i = 0; i < 3; ++i) area.col(i + 1) = factor * now.col((i + 1) % 3).cross(now.col((i + 2) % 3));
    area.col(0) = -area.rightCols<3>().rowwise().sum();
    for (const Index a : cell)
      for (int i = 0; i < 4; ++i) m.root.row(a).segment<3>(3 * cell[i]) += area.col(i).transpose();
  }
  flow.multiplyRoot(m.root.data(), 3 * std::size_t(n));
  m.multiplied = false;
}

void DenseCoupling::assemble(double factor, const Index* slots, std::vector<double>& values) {
  const auto n = Eigen::Index(rest_.size());
  Matrices& m = *matrices_;
  if (!m.multiplied) {
    m.fluid.setZero(3 * n, 3 * n);
    m.fluid.selfadjointView<Eigen::Lower>().rankUpdate(m.root.transpose());
    m.multiplied = true;
  }
  const Eigen::MatrixXd& k = m.fluid;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      double* block = values.data() + std::size_t(*slots++) * 9;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const Eigen::Index row = 3 * i + r, column = 3 * j + c;
          block[3 * r + c] -= factor * k(std::max(row, column), std::min(row, column));
        }
    }
}

void DenseCoupling::assembleDiagonal(double factor, std::vector<double>& blocks) const {
  const Eigen::MatrixXd& root = matrices_->root;
  for (Eigen::Index i = 0; i < Eigen::Index(rest_.size()); ++i)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        blocks[9 * std::size_t(first_row_ + i) + std::size_t(3 * r + c)] -=
            factor * root.col(3 * i + r).dot(root.col(3 * i + c));
}

}  // namespace stroma::porous
