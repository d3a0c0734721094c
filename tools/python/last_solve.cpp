// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/python/last_solve.h"

#include <pybind11/numpy.h>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/simulation/integrator.h"

namespace stroma::python {
namespace {

std::vector<double> numbersOf(ConstRows rows) {
  std::vector<double> numbers;
  numbers.reserve(3 * std::size_t(rows.count));
  for (Index row = 0; row < rows.count; ++row)
    for (int c = 0; c < 3; ++c) numbers.push_back(rows[row][c]);
  return numbers;
}

template <class Number>
py::array arrayOf(const std::vector<Number>& numbers) {
  return py::array_t<Number>(py::ssize_t(numbers.size()), numbers.data());
}

py::array threeColumns(const std::vector<double>& numbers) {
  return py::array_t<double>({py::ssize_t(numbers.size() / 3), py::ssize_t(3)}, numbers.data());
}

/// P of each row, shape (rows, 3, 3). A projector of ties or relations is of several rows together, and none of these.
py::array_t<double> projectorsOf(System& system) {
  const py::ssize_t rows = system.independentRows();
  py::array_t<double> out({rows, py::ssize_t(3), py::ssize_t(3)});
  Vector unit(system.independentRows());
  for (int column = 0; column < 3; ++column) {
    clear(unit);
    for (py::ssize_t row = 0; row < rows; ++row) unit.rows().data[std::size_t(row) * row_doubles + std::size_t(column)] = 1;
    system.constraints().project(unit);
    for (py::ssize_t row = 0; row < rows; ++row)
      for (int c = 0; c < 3; ++c) out.mutable_at(row, c, column) = unit.rows().data[std::size_t(row) * row_doubles + std::size_t(c)];
  }
  return out;
}

}  // namespace

void LastSolve::solved(SystemMatrix& matrix, ConstRows b, ConstRows x) {
  if (!keeps_matrices) return;
  std::erase_if(systems_, [](const auto& each) { return each.second.identity.use_count() == 1; });  // of meshes before
  Equations& kept = systems_[matrix.identity().get()];
  kept.identity = matrix.identity();
  kept.matrix = matrix.assemble();
  kept.b = numbersOf(b), kept.x = numbersOf(x);
}

void LastSolve::constraintGradients(const System& system, const LagrangianRows& rows, double displacement) {
  Equations& kept = systems_[system.matrix().identity().get()];
  kept.identity = system.matrix().identity();
  kept.row_starts.assign(1, 0), kept.columns.clear(), kept.gradients.clear();
  kept.displacement = displacement, kept.has_gradients = true;
  Vector all(system.allRows());
  for (const LagrangianRows::Row& row : rows.rows()) {
    clear(all);
    for (const auto& [at, gradient] : rows.entriesOf(row)) all[at] += gradient;
    system.mappingChain().pullBack(all);
    for (Index i = 0; i < all.count(); ++i)
      for (int c = 0; c < 3; ++c)
        if (const double number = Vec3(all[i])[c]; number != 0) kept.columns.push_back(3 * i + c), kept.gradients.push_back(number);
    kept.row_starts.push_back(int(kept.columns.size()));
  }
}

/// With each change of a mesh systems are others.
static std::string sinceWhen(bool has_changed_meshes) {
  return has_changed_meshes ? " since a mesh of the scene has changed" : " since it is watched";
}

py::tuple LastSolve::equations(System& system, bool has_changed_meshes) const {
  const auto found = systems_.find(system.matrix().identity().get());
  if (found == systems_.end() || found->second.matrix.rows() <= 0)
    throw ComponentError(system.integrator().path() + " has solved no linear system" + sinceWhen(has_changed_meshes), "a step before");
  if (!system.constraints().relations().empty() || !system.constraints().groups().empty())
    throw ComponentError(system.integrator().path() + " moves nodes that are tied: its matrix has theirs in the place of single nodes",
                         "a system without attached nodes");
  const Equations& kept = found->second;
  const BlockMatrix& matrix = kept.matrix;
  const py::ssize_t blocks = matrix.blocks();
  const py::tuple of_matrix =
      py::make_tuple(py::array_t<double>({blocks, py::ssize_t(3), py::ssize_t(3)}, matrix.values().data()),
                     arrayOf(matrix.columns()), arrayOf(matrix.rowStart()));
  return py::make_tuple(of_matrix, projectorsOf(system), threeColumns(kept.b), threeColumns(kept.x));
}

py::tuple LastSolve::gradients(const System& system, bool has_changed_meshes) const {
  const auto found = systems_.find(system.matrix().identity().get());
  if (found == systems_.end() || !found->second.has_gradients)
    throw ComponentError(system.integrator().path() + " has looked for no forces of constraint" + sinceWhen(has_changed_meshes),
                         "a step before");
  const Equations& kept = found->second;
  return py::make_tuple(arrayOf(kept.row_starts), arrayOf(kept.columns), arrayOf(kept.gradients), kept.displacement);
}

}  // namespace stroma::python
