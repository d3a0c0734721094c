// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/krylov_solver.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/mass.h"
#include "framework/scene/names.h"

namespace stroma {

bool matrixDependsOnState(const Node& root) {
  std::vector<ForceField*> fields;
  std::vector<Mapping*> mappings;
  std::vector<Mass*> masses;
  root.collect(fields), root.collect(mappings), root.collect(masses);
  const auto varies = [](const ForceField* field) {
    const ForceTraits traits = field->traits();
    return traits.velocity_dependent || (traits.has_stiffness && !traits.constant_stiffness);
  };
  return std::ranges::any_of(fields, varies) || !std::ranges::all_of(mappings, &Mapping::isLinear) ||
         std::ranges::any_of(masses, &Mass::turns);
}

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
