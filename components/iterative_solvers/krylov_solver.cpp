// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/krylov_solver.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/names.h"

namespace stroma {

void KrylovSolver::declare(DataTable& table) {
  table.add("iterations", iterations_)
      .recompiled()
      .help("largest number of iterations; a scene that must keep a frame rate caps them")
      .unit("-")
      .min(1);
  table.add("tolerance", tolerance_)
      .atOnce()
      .help("stop when |b - A x| <= tolerance |b|; 1e-5 where the scene writes iterations and no tolerance")
      .unit("-")
      .min(0)
      .max(1, false);
  table.add("template", template_)
      .help(
          "auto, GraphScattered (matrix-free) or CompressedRowSparseMatrix, CompressedRowSparseMatrixMat3x3 "
          "(assembled)");
  table.add("graph", graph_)
      .help("relative residual after each iteration of the last solve, whichever integrator asked for it")
      .unit("-")
      .output();
}

void KrylovSolver::declarePrecision(DataTable& table) {
  precision_ = Precision::automatic;
  table.addChoice("precision", precision_, {"auto", "single", "double"})
      .help(
          "of products through the elements, where force fields have them in single precision; the residual that ends a solve is "
          "in double; auto: single for tolerances of 1e-5 and more or up to 25 iterations, where a body is large enough to gain");
}

// Few iterations end far from where rounding shows, and loose tolerances too. In cache a product gains too little.
bool KrylovSolver::takesSingle(const SystemMatrix& matrix, double relative_residual) const {
  constexpr int few_iterations = 25;
  constexpr Index few_rows = 2500;  // are not asked
  constexpr double loose = 1e-5, worth_nanoseconds = 4e4;
  if (precision_ == Precision::double_precision) return false;
  if (precision_ == Precision::single_precision) return matrix.singleGain() > 0;
  const bool is_loose = std::max(tolerance(), relative_residual) >= loose || (is_capped_ && iterations_ <= few_iterations);
  return is_loose && matrix.rows() >= few_rows && matrix.singleGain() >= worth_nanoseconds;
}

std::string KrylovSolver::plan(const SystemMatrix& matrix) const {
  if (form_ == Form::assembled || !takesSingle(matrix, 0)) return {};
  return "products in single precision, the residual that ends a solve in double";
}

void KrylovSolver::init() {
  is_capped_ = data().find("iterations")->isSet();
  tolerance_data_ = data().find("tolerance");
  if (is_capped_) expected_iterations_ = iterations_;
  constexpr double loosest = 0.1;
  if (tolerance_ > loosest)
    warn(fmt::format("tolerance = {:g} leaves that share of the forces out of balance in every solve: what moves is no solution "
                     "of the step's equations",
                     tolerance_),
         "tolerance=\"1e-5\" or less");
  const std::vector<std::string> assembled = {"CompressedRowSparseMatrix", "CompressedRowSparseMatrixd",
                                              "CompressedRowSparseMatrixMat3x3", "CompressedRowSparseMatrixMat3x3d"};
  if (template_ == "auto" || template_.empty()) {
    form_ = Form::automatic;
  } else if (template_ == "GraphScattered") {
    form_ = Form::product;
  } else if (std::find(assembled.begin(), assembled.end(), template_) != assembled.end()) {
    form_ = Form::assembled;
  } else {
    const std::vector<std::string> words = {"auto", "GraphScattered", assembled[0], assembled[2]};
    throw ComponentError("template '" + template_ + "' is not a form of matrix that this solver has",
                         "auto, GraphScattered, CompressedRowSparseMatrix or CompressedRowSparseMatrixMat3x3",
                         nearest(template_, words));
  }
  graph_.reserve(std::size_t(std::min(iterations_, 100000)) + 1);
}

}  // namespace stroma
