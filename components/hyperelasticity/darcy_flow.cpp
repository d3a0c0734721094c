// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/darcy_flow.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <stdexcept>

namespace stroma {

struct DarcyFlow::Matrices {
  Eigen::SparseMatrix<double> gradients, matrix;  ///< L, and s M + h kappa L
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  Eigen::VectorXd diagonal, work;
};

DarcyFlow::DarcyFlow() : matrices_(std::make_unique<Matrices>()) {}
DarcyFlow::~DarcyFlow() = default;

void DarcyFlow::build(const porous::PorousCells& cells, const std::vector<Index>& drained) {
  const std::size_t n = cells.rest().size();
  volume_.assign(n, 0.);
  drained_.assign(n, 0);
  for (Index node : drained) drained_[node] = 1;
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    const auto shares = cells.shares(cell);
    std::size_t a = 0;
    for (Index node : cells.nodes(cell)) volume_[node] += shares[a++];
  }
  buildGradients(cells);
}

void DarcyFlow::buildGradients(const porous::PorousCells& cells) {
  const auto n = Eigen::Index(volume_.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    const auto gradients = cells.gradients(cell);
    const auto nodes = cells.nodes(cell);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < nodes.size(); ++b)
        if (const Index i = nodes[a], j = nodes[b]; !isDrained(i) && !isDrained(j))
          entries.emplace_back(i, j, gradients[a][b]);
  }
  for (Eigen::Index i = 0; i < n; ++i) entries.emplace_back(i, i, 0.);
  Matrices& m = *matrices_;
  m.gradients.resize(n, n);
  m.gradients.setFromTriplets(entries.begin(), entries.end());
  m.matrix = m.gradients;
  m.solver.analyzePattern(m.matrix);
  m.work.resize(n);
}

void DarcyFlow::setStep(double h, double storage, double permeability) {
  // differences of times have round-off of their own: equal steps share a factor, and no result depends on which
  int exponent = 0;
  h = std::round(std::frexp(h, &exponent) * 0x1p30);
  h = std::ldexp(h * 0x1p-30, exponent);
  if (h == step_) return;
  step_ = h;
  Matrices& m = *matrices_;
  m.matrix = m.gradients * (h * permeability);
  for (Eigen::Index i = 0; i < m.matrix.rows(); ++i)
    m.matrix.coeffRef(i, i) += isDrained(Index(i)) ? 1 : storage * volume_[i];
  m.solver.factorize(m.matrix);
  if (m.solver.info() != Eigen::Success)
    throw std::runtime_error(fmt::format("the fluid's matrix of a step of {:g} s has no factors: storage {:g} 1/Pa, permeability {:g}", h,
                                         storage, permeability));
  m.diagonal = m.solver.vectorD();
  ++factorisations_;
}

void DarcyFlow::solve(Rows values) const {
  Matrices& m = *matrices_;
  const auto& place = m.solver.permutationP().indices();
  for (Eigen::Index i = 0; i < m.work.size(); ++i) m.work[place[i]] = isDrained(Index(i)) ? 0 : values[Index(i)].x();
  m.solver.matrixL().solveInPlace(m.work);
  m.work.array() /= m.diagonal.array();
  m.solver.matrixU().solveInPlace(m.work);
  for (Eigen::Index i = 0; i < m.work.size(); ++i) values[Index(i)].x() = m.work[place[i]];
}

/// Forth and back, of cubes of 729 to 4,913 nodes.
double DarcyFlow::solveCost() const {
  constexpr double each = 1.45;
  return step_ > 0 ? each * double(matrices_->solver.matrixL().nestedExpression().nonZeros()) : 0;
}

void DarcyFlow::multiplyRoot(double* columns, std::size_t count) const {
  const Matrices& m = *matrices_;
  const Eigen::Index n = m.matrix.rows();
  Eigen::Map<Eigen::MatrixXd> values(columns, n, Eigen::Index(count));
  for (Eigen::Index i = 0; i < n; ++i)
    if (isDrained(Index(i))) values.row(i).setZero();
  Eigen::MatrixXd ordered = m.solver.permutationP() * values;
  m.solver.matrixL().solveInPlace(ordered);
  values = m.diagonal.cwiseSqrt().cwiseInverse().asDiagonal() * ordered;
}

}  // namespace stroma
