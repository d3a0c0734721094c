// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/krylov_solver.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/names.h"

namespace stroma {

namespace {

/// Whether three of these rows of the state, not in a line, cannot move: with them the state has no free motion.
bool isHeldBy(const std::vector<NodeProjector>& projectors, const State& state) {
  const Vec3* first = nullptr;
  Vec3 edge = Vec3::Zero();
  for (const NodeProjector& held : projectors) {
    const Index node = held.row - state.firstRow();
    if (node < 0 || node >= state.size() || !held.projector.isZero()) continue;
    const Vec3& place = state.rest_position[std::size_t(node)];
    if (!first) {
      first = &place;
      continue;
    }
    const Vec3 side = place - *first;
    constexpr double in_line = 1e-3;
    if (edge.cross(side).norm() > in_line * edge.norm() * side.norm()) return true;
    if (side.norm() > edge.norm()) edge = side;
  }
  return false;
}

}  // namespace

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
          "of products through the elements, where force fields have them in single precision; a tolerance is met in double; "
          "auto: single for tolerances of 1e-5 and more or up to 25 iterations, where a body is large enough to gain and none is "
          "free to move: three nodes of each, not in a line, are held for the whole run");
}

// Whoever is free to move keeps angular momentum, which single precision rounds. What holds only for a time does not count. All
// bodies of the scene are asked: the matrix does not say whose it is.
bool KrylovSolver::areBodiesHeld() const {
  fields_.clear(), constraints_.clear();
  node().root().collect(fields_);
  node().root().collect(constraints_);
  const auto holds = [this](const ProjectiveConstraint* constraint, const State& state) {
    if (constraint->endTime() >= 0 || !constraint->isConstant()) return false;
    projectors_.clear();
    constraint->addProjectors(0, projectors_);
    return !projectors_.empty() && &constraint->state() == &state && isHeldBy(projectors_, state);
  };
  return std::all_of(fields_.begin(), fields_.end(), [&](const ForceField* field) {
    return field->cost().single <= 0 || std::any_of(constraints_.begin(), constraints_.end(), [&](const auto* constraint) {
             return holds(constraint, field->state());
           });
  });
}

// Few iterations end far from where rounding shows, and loose tolerances too. In cache a product gains too little.
bool KrylovSolver::takesSingle(const SystemMatrix& matrix, double relative_residual) const {
  constexpr int few_iterations = 25;
  constexpr Index few_rows = 2500;  // are not asked
  constexpr double loose = 1e-5, worth_nanoseconds = 4e4;
  if (precision_ == Precision::double_precision) return false;
  if (precision_ == Precision::single_precision) return matrix.singleGain() > 0;
  const bool is_loose = std::max(tolerance(), relative_residual) >= loose || (is_capped_ && iterations_ <= few_iterations);
  return is_loose && matrix.rows() >= few_rows && matrix.singleGain() >= worth_nanoseconds && areBodiesHeld();
}

std::string KrylovSolver::plan(const SystemMatrix& matrix) const {
  if (form_ == Form::assembled || !takesSingle(matrix, 0)) return {};
  return "products in single precision, a tolerance met in double";
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
