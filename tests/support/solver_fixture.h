// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tests/support/dense_algebra.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/stored_matrix.h"

namespace stroma::test {

/// A linear solver made by the loader from its XML element, in a scene that holds nothing else.
struct SolverInScene {
  Scene scene;
  LinearSolver* solver = nullptr;
  explicit SolverInScene(const std::string& element)
      : scene(sceneFromText("<Node name=\"root\">" + element + "</Node>")) {
    std::vector<LinearSolver*> found;
    scene.root->collect(found);
    solver = found.at(0);
  }
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Vector& x) {
    if (x.count() != b.count) x.resize(b.count);
    return solver->solve(matrix, b, x);
  }
  std::vector<double> reals(const char* attribute) const {
    return *std::get<std::vector<double>*>(solver->data().find(attribute)->pointer());
  }
};

inline double relativeError(ConstRows x, const Eigen::VectorXd& exact) {
  return (dense(x) - exact).norm() / exact.norm();
}

}  // namespace stroma::test
