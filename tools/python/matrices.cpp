// SPDX-License-Identifier: LGPL-2.1-or-later
// The matrices of a system, as compressed rows of 3x3 blocks. They are computed in a copy of the simulation: asking for one
// changes no bit of a run.
#include <pybind11/numpy.h>

#include <algorithm>

#include "framework/simulation/integrator.h"
#include "tools/python/engine.h"
#include "tools/python/played.h"

namespace stroma::python {
namespace {

System& systemOf(Engine& engine, const std::string& integrator) {
  const Systems& systems = engine.simulation().systems();
  std::vector<std::string> paths;
  for (const auto& system : systems) {
    paths.push_back(system->integrator().path());
    if (paths.back() == integrator || (integrator.empty() && systems.size() == 1)) return *system;
  }
  if (!integrator.empty())
    throw ComponentError(integrator + " is no integrator", "the path of an integrator", nearest(integrator, paths));
  throw ComponentError("the scene has " + std::to_string(paths.size()) + " integrators: a matrix is that of one",
                       "the path of an integrator", paths.empty() ? std::string() : paths.front());
}

/// (values (blocks, 3, 3), columns, row starts)
py::tuple tupleOf(const BlockMatrix& matrix) {
  const py::ssize_t blocks = matrix.blocks();
  return py::make_tuple(py::array_t<double>({blocks, py::ssize_t(3), py::ssize_t(3)}, matrix.values().data()),
                        py::array_t<Index>(blocks, matrix.columns().data()),
                        py::array_t<Index>(py::ssize_t(matrix.rowStart().size()), matrix.rowStart().data()));
}

MatrixFactors factorsOf(const std::string& kind) {
  MatrixFactors factors;
  if (kind == "stiffness") {
    factors.stiffness = 1;
  } else if (kind == "mass") {
    factors.mass = 1;
  } else if (kind == "damping") {
    factors.damping = 1;
  } else if (kind != "-held-") {
    throw ComponentError("there is no matrix '" + kind + "'", "stiffness, mass or damping",
                         nearest(kind, {"stiffness", "mass", "damping"}));
  }
  return factors;
}

/// Masses turn with their frames: at the present orientations.
void takeTurns(const System& system) {
  for (Mass* mass : system.actors().masses)
    if (mass->turns()) mass->update(system.mappingChain().positions(system.x));
}

/// Of all rows, before constraints; K and C of the present x and v.
BlockMatrix unconstrained(System& system, const MatrixFactors& factors) {
  if (!system.mappingChain().empty())
    throw ComponentError("forces act through mappings: the matrix exists only with constraints", "constrained=True");
  const Actors& actors = system.actors();
  BlockPattern pattern(system.allRows());
  for (const Mass* mass : actors.masses) mass->addPattern(pattern);
  for (const ForceField* field : actors.force_fields) field->addPattern(pattern);
  BlockMatrix matrix(std::move(pattern));
  for (Mass* mass : actors.masses) mass->prepareAssembly(matrix);
  for (ForceField* field : actors.force_fields) field->prepareAssembly(matrix);
  if (factors.mass != 0)
    for (const Mass* mass : actors.masses) mass->addTo(factors.mass, matrix);
  if (factors.stiffness != 0)
    for (const ForceField* field : actors.stiff_fields) field->addStiffness(factors.stiffness, matrix);
  if (factors.damping != 0)
    for (const ForceField* field : actors.damped_fields) field->addDamping(factors.damping, matrix);
  system.matrix().termsChanged();  // places in its blocks are looked up again
  return matrix;
}

/// A system whose matrix is made in steps, with the forces at its present state.
System& withForces(Engine& engine, const std::string& integrator) {
  System& system = systemOf(engine, integrator);
  if (system.integrator().stateOwner())
    throw ComponentError(system.integrator().path() + " has computed its matrix beforehand",
                         "an integrator that makes it in steps");
  Vector force(system.allRows());
  system.computeForce(system.x, system.v, force);
  takeTurns(system);
  return system;
}

py::tuple matrixOf(const std::shared_ptr<Engine>& engine, const std::string& kind, bool constrained, const std::string& integrator) {
  const MatrixFactors factors = factorsOf(kind);
  System& system = withForces(engine->twin(), integrator);
  return tupleOf(constrained ? system.matrix().withFactors(factors).assemble() : unconstrained(system, factors));
}

/// K of a force field or M of a mass alone, of all rows: (matrix, first row of its state, how many).
py::tuple partOf(const std::shared_ptr<Engine>& engine, const std::string& path) {
  Engine& used = engine->isOwn() ? engine->twin() : *engine;
  used.between();
  Component& component = used.component(path);
  for (const auto& system : used.simulation().systems()) {
    const Actors& actors = system->actors();
    BlockPattern pattern(system->allRows());
    const auto made = [&](auto* part, const auto& fill) {
      part->addPattern(pattern);
      BlockMatrix matrix(std::move(pattern));
      part->prepareAssembly(matrix);
      fill(matrix);
      system->matrix().termsChanged();  // places in its blocks are looked up again
      return py::make_tuple(tupleOf(matrix), part->state().firstRow(), part->state().size());
    };
    takeTurns(*system);
    for (Mass* mass : actors.masses)
      if (mass == &component) return made(mass, [&](BlockMatrix& matrix) { mass->addTo(1, matrix); });
    for (ForceField* field : actors.force_fields) {
      if (field != &component) continue;
      Vector force(system->allRows());
      system->computeForce(system->x, system->v, force);
      const bool is_stiff = std::find(actors.stiff_fields.begin(), actors.stiff_fields.end(), field) != actors.stiff_fields.end();
      return made(field, [&](BlockMatrix& matrix) {
        if (is_stiff) field->addStiffness(1, matrix);
      });
    }
  }
  throw ComponentError(path + " is no force field and no mass that acts on what moves: it has no matrix");
}

/// x of A x = b, A with constraints, by the linear solver of the scene.
py::array solutionOf(const std::shared_ptr<Engine>& engine, const Array& given, double mass, double damping, double stiffness,
                     const std::string& integrator) {
  System& system = withForces(engine->twin(), integrator);
  LinearSolver* solver = system.linearSolver();
  if (!solver)
    throw ComponentError(system.integrator().path() + " solves no linear systems", "an implicit integrator, or matrix() with SciPy");
  const py::ssize_t rows = system.independentRows();
  if (given.ndim() != 2 || given.shape(0) != rows || given.shape(1) != 3)
    throw py::value_error("expected an array of shape (" + std::to_string(rows) + ", 3)");
  Vector b(system.independentRows()), x(system.independentRows());
  for (py::ssize_t row = 0; row < rows; ++row)
    std::copy_n(given.data() + 3 * row, 3, b.rows().data + std::size_t(row) * row_doubles);
  system.constraints().project(b.rows());
  MatrixFactors factors;
  factors.mass = mass, factors.damping = damping, factors.stiffness = stiffness;
  MechanicalMatrix& matrix = system.matrix().withFactors(factors);
  if (solver->needsSymmetric() && !matrix.symmetric())
    throw ComponentError(solver->path() + " needs a symmetric matrix, which this is not", "a SparseLUSolver, or matrix() with SciPy");
  const SolveReport report = solver->solve(matrix, b, x);
  const bool is_slow = report.stop == SolveStop::iteration_limit || report.stop == SolveStop::stagnated;
  if (report.stop != SolveStop::converged && report.stop != SolveStop::zero_right_side)
    throw ComponentError(solver->path() + " finds no solution: " + std::string(describe(report.stop)),
                         is_slow ? "more iterations of it, a wider tolerance, or a direct solver"
                                 : "factors with which the matrix is definite (K = dF/dx has none above zero), or another solver");
  system.constraints().project(x.rows());
  py::array_t<double> out({rows, py::ssize_t(3)});
  for (py::ssize_t row = 0; row < rows; ++row)
    std::copy_n(x.rows().data + std::size_t(row) * row_doubles, 3, out.mutable_data() + 3 * row);
  return out;
}

py::array forceOf(const std::shared_ptr<Engine>& engine, const std::string& integrator) {
  System& system = systemOf(engine->twin(), integrator);
  Vector force(system.allRows());
  system.computeForce(system.x, system.v, force);
  py::array_t<double> out({py::ssize_t(system.independentRows()), py::ssize_t(3)});
  for (Index row = 0; row < system.independentRows(); ++row)
    std::copy_n(force.rows().data + std::size_t(row) * row_doubles, 3, out.mutable_data() + 3 * row);
  return out;
}

/// Of the last step, of an engine whose solves are watched.
LastSolve& lastSolveOf(Engine& engine) {
  engine.between();
  if (!engine.lastSolve()) throw std::runtime_error("nobody watches the solves of steps: watch_solves() comes before the step");
  return *engine.lastSolve();
}

}  // namespace

void bindMatrices(py::module_& module) {
  module.def("matrix_of", &matrixOf);
  module.def("matrix_of_part", &partOf);
  module.def("solution_of", &solutionOf);
  module.def("force_of", &forceOf);
  module.def("last_equations", [](const std::shared_ptr<Engine>& engine, const std::string& integrator) {
    return lastSolveOf(*engine).equations(systemOf(*engine, integrator), engine->simulation().hasChangedMeshes());
  });
  module.def("last_gradients", [](const std::shared_ptr<Engine>& engine, const std::string& integrator) {
    return lastSolveOf(*engine).gradients(systemOf(*engine, integrator), engine->simulation().hasChangedMeshes());
  });
  // (rows, (path, first row, how many) of each state, mapped ones too)
  module.def("rows_of_states", [](const std::shared_ptr<Engine>& engine, const std::string& integrator) {
    const System& system = systemOf(*engine, integrator);
    py::list states;
    for (const State* state : system.states()) states.append(py::make_tuple(state->path(), state->firstRow(), state->size()));
    return py::make_tuple(system.allRows(), states);
  });
  // of a step that somebody else makes in this thread
  module.def("watch_step", [](const std::shared_ptr<Engine>& engine, bool is_made) {
    stepWatch() = is_made ? engine->lastSolve() : nullptr;
  });
  module.def("systems_of", [](const std::shared_ptr<Engine>& engine) {
    py::list out;
    for (const auto& system : engine->simulation().systems()) {
      py::list states;
      for (const State* state : system->states())
        if (state->firstRow() < system->independentRows())
          states.append(py::make_tuple(state->path(), state->firstRow(), state->size()));
      out.append(py::make_tuple(system->integrator().path(), states));
    }
    return out;
  });
}

}  // namespace stroma::python
