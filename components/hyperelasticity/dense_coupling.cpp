// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/dense_coupling.h"

#include <Eigen/Core>
#include <algorithm>
#include <numeric>

namespace stroma::porous {

struct DenseCoupling::Matrices {
  Eigen::MatrixXd gradients;  ///< U, shape (nodes, 3 nodes); a column has the neighbours of its node
  Eigen::MatrixXd root;       ///< Y = A^-1/2 U: K_fluid = -Y^T Y
  Eigen::MatrixXd fluid;      ///< -K_fluid, its lower triangle, shape (3 nodes, 3 nodes)
  bool multiplied = false;
  Eigen::MatrixXd inverse;  ///< A^-1, shape (nodes, nodes), for the diagonal alone
  long inverse_of = -1;     ///< DarcyFlow::factorisations() of it
  std::vector<Index> neighbours;
};

DenseCoupling::DenseCoupling(const PorousCells& cells, const Sponge& sponge, Index first_row)
    : cells_(cells), sponge_(sponge), first_row_(first_row), matrices_(std::make_unique<Matrices>()) {}
DenseCoupling::~DenseCoupling() = default;

void DenseCoupling::addPattern(BlockPattern& pattern) const {
  std::vector<Index> rows(nodes());
  std::iota(rows.begin(), rows.end(), first_row_);
  pattern.addClique(rows.data(), int(rows.size()));
}

std::vector<Index> DenseCoupling::slots(const BlockMatrix& matrix) const {
  const Index n = Index(nodes());
  std::vector<Index> slots;
  slots.reserve(nodes() * nodes());
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) slots.push_back(matrix.slot(first_row_ + i, first_row_ + j));
  return slots;
}

void DenseCoupling::update(ConstRows x, const DarcyFlow& flow) {
  Matrices& m = *matrices_;
  const auto n = Eigen::Index(nodes());
  m.gradients.setZero(n, 3 * n);
  for (std::size_t cell = 0; cell < cells_.count(); ++cell) {
    const auto of = cells_.nodes(cell);
    PorousCells::OfNodes<Vec3> now;
    std::transform(of.begin(), of.end(), now.begin(), [&](Index i) -> Vec3 { return x[first_row_ + i]; });
    const auto area = cells_.areas(cell, now.data(), sponge_);
    const auto fraction = cells_.fractions(cell);
    for (std::size_t a = 0; a < of.size(); ++a)
      for (std::size_t i = 0; i < of.size(); ++i)
        m.gradients.row(of[a]).segment<3>(3 * of[i]) += fraction[a] * area[i].transpose();
  }
  flow_ = &flow;
  m.multiplied = false;
}

void DenseCoupling::assemble(double factor, const Index* slots, std::vector<double>& values) {
  const auto n = Eigen::Index(nodes());
  Matrices& m = *matrices_;
  if (!m.multiplied) {
    m.root = m.gradients;
    flow_->multiplyRoot(m.root.data(), 3 * std::size_t(n));
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
  Matrices& m = *matrices_;
  const auto n = Eigen::Index(nodes());
  if (m.inverse_of != flow_->factorisations()) {
    m.inverse.setIdentity(n, n);
    flow_->multiplyRoot(m.inverse.data(), std::size_t(n));
    m.inverse = (m.inverse.transpose() * m.inverse).eval();
    m.inverse_of = flow_->factorisations();
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto of_node = m.gradients.middleCols<3>(3 * i);
    m.neighbours.clear();
    for (Eigen::Index a = 0; a < n; ++a)
      if (of_node(a, 0) != 0 || of_node(a, 1) != 0 || of_node(a, 2) != 0) m.neighbours.push_back(Index(a));
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(blocks.data() + 9 * std::size_t(first_row_ + i));
    for (const Index a : m.neighbours) {
      Eigen::RowVector3d answer = Eigen::RowVector3d::Zero();
      for (const Index b : m.neighbours) answer += m.inverse(a, b) * of_node.row(b);
      block -= factor * (of_node.row(a).transpose() * answer);
    }
  }
}

}  // namespace stroma::porous
