// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies whose matrices change from solve to solve, for solvers that choose by themselves.
#pragma once
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {

/// A beam of 3,479 nodes along z; `density` as the mass of an implicit step.
struct Beam {
  explicit Beam(double density) : Beam(made(density)) {}
  explicit Beam(StoredMatrix of) : matrix(std::move(of)), b(matrix.rows()) {
    for (Index i = 0; i < b.count(); ++i)
      if (matrix.nodes[std::size_t(i)].z() > 0) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made(double density, std::array<int, 3> cells = {6, 6, 70}) {
    ElasticBlock block;
    block.cells = cells;
    block.density = density;
    StoredMatrix matrix = block.matrix();
    matrix.nodes.resize(std::size_t(matrix.rows()));
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes[std::size_t(block.node(i, j, k))] = Vec3(i, j, k);
    return matrix;
  }
  /// Iterations of the next step's solve: the values may have changed.
  int solve(SolverInScene& solver) {
    ++matrix.revision_number;
    x = Vector(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    Vector r(b.count());
    matrix.values.multiply(x, r);
    EXPECT_LE(distance(r, b), 1.2e-8 * norm(b));
    return report.iterations;
  }
  StoredMatrix matrix;
  Vector b, x;
};

/// A solver in a scene whose matrices depend on places, by a spring: what a scene without one shows its solver is known to stay.
struct SolverWhereMatricesVary : SolverInScene {
  explicit SolverWhereMatricesVary(const std::string& element)
      : SolverInScene(element + "<Node name=\"two\"><MechanicalObject position=\"0 0 0 1 0 0\"/><SpringForceField "
                      "springsIndices1=\"0\" springsIndices2=\"1\" lengths=\"1\" stiffness=\"1\" damping=\"0\"/></Node>") {}
};

inline std::string choiceOf(const SolverInScene& solver) { return solver.solver->data().find("choice")->print(); }
inline std::string changesOf(const SolverInScene& solver) { return solver.solver->data().find("changes")->print(); }
inline bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

/// A compact body of 3,375 nodes, as Beam.
struct Cube : Beam {
  explicit Cube(double density, Index cells = 14) : Beam(cubeOf(density, cells)) {}
  static StoredMatrix cubeOf(double density, Index cells) {
    ElasticBlock block;
    block.cells = {cells, cells, cells};
    block.density = density;
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes.push_back(Vec3(i, j, k));
    return matrix;
  }
};

/// Fifteen times as long as wide, and stiff in one half and then in the other: no former factors serve, and a direct solver costs
/// least. `shift` times the identity makes it indefinite with a positive diagonal.
struct Needle {
  Needle() : matrix(made(false)), other(made(true).values), b(matrix.rows()) {
    for (Index i = 25; i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
  }
  static StoredMatrix made(bool is_stiff_above) {
    ElasticBlock block;
    block.cells = {4, 4, 60};
    block.poisson = 0.49;
    block.stiffer = [is_stiff_above](Vec3 at) { return (at.z() > 30) == is_stiff_above ? 10. : 1.; };
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k < block.nodes(2); ++k)
      for (Index j = 0; j < block.nodes(1); ++j)
        for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes.push_back(Vec3(i, j, k));
    return matrix;
  }
  SolveReport solve(SolverInScene& solver, double shift = 0) {
    ++matrix.revision_number;
    std::swap(matrix.values, other);
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, shift * Mat3::Identity());
    x = Vector(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    Vector r(b.count());
    matrix.values.multiply(x, r);
    residual = distance(r, b) / norm(b);
    for (Index i = 0; i < matrix.rows(); ++i) matrix.values.add(i, i, -shift * Mat3::Identity());
    return report;
  }
  StoredMatrix matrix;
  BlockMatrix other;  ///< of the next solve
  Vector b, x;
  double residual = 0;
};

}  // namespace stroma::test
