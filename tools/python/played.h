// SPDX-License-Identifier: LGPL-2.1-or-later
// A Python object that a component calls, found by the number that its attribute `played` holds (stroma/played.py).
#pragma once
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <algorithm>

#include "framework/mechanics/state.h"
#include "framework/scene/data.h"
#include "tools/python/python.h"

namespace stroma::python {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<Index, py::array::c_style | py::array::forcecast>;

/// Objects of Python that a component holds: they are let go with the interpreter's lock, or not at all when it has gone.
template <class... Objects>
void letGo(Objects&... objects) {
  if (!Py_IsInitialized()) {
    (objects.release(), ...);
    return;
  }
  const py::gil_scoped_acquire lock;
  ((objects = py::object()), ...);
}

/// The object with this number. With the interpreter's lock; throws ComponentError.
inline py::object playedObject(int number) {
  try {
    return py::module_::import("stroma.played").attr("take")(number);
  } catch (const py::error_already_set& error) {
    throw ComponentError(error.what());
  }
}

/// What it says of itself: an attribute that is true or false; false when it has none.
inline bool says(const py::object& object, const char* name) {
  return py::bool_(py::getattr(object, name, py::bool_(false))).cast<bool>();
}

/// Numbers of a node as a scene has them: 3 of points; of frames 7 in positions (centre, quaternion x y z w) and 6 in all else.
inline py::ssize_t widthOf(const State& state, bool places) {
  return state.hasFrames() ? (places ? 7 : 6) : state.hasPointsOnly() ? 3 : py::ssize_t(state.rows_per_node);
}

/// How many of them are in a row, and in which row of the node the k-th one is.
inline py::ssize_t perRow(const State& state) { return state.hasFrames() || state.hasPointsOnly() ? 3 : 1; }

/// A state's rows, (nodes, width), copied: no array of Python leads into a vector of a solver.
inline Array numbersOf(const State& state, ConstRows own, bool places) {
  const py::ssize_t width = widthOf(state, places), per_row = perRow(state);
  Array out({py::ssize_t(state.nodes()), width});
  double* to = out.mutable_data();
  for (Index row = 0; row < own.count; ++row) {
    const bool is_turn = state.kindOf(row) == RowKind::turn;
    const py::ssize_t count = is_turn && places ? 4 : per_row;
    to = std::copy_n(own.data + std::size_t(row) * row_doubles, count, to);
  }
  return out;
}

/// The other way; with `adds` they are added. Throws py::value_error, with what they are, where they are of another shape.
inline void putNumbers(const State& state, const Array& numbers, bool places, Rows own, bool adds, const std::string& what) {
  const py::ssize_t width = widthOf(state, places), per_row = perRow(state);
  if (numbers.ndim() != 2 || numbers.shape(0) != state.nodes() || numbers.shape(1) != width)
    throw py::value_error(fmt::format("{} is no array of shape ({}, {})", what, state.nodes(), width));
  const double* from = numbers.data();
  for (Index row = 0; row < own.count; ++row) {
    const py::ssize_t count = state.kindOf(row) == RowKind::turn && places ? 4 : per_row;
    double* to = own.data + std::size_t(row) * row_doubles;
    for (py::ssize_t i = 0; i < count; ++i) to[i] = (adds ? to[i] : 0) + from[i];
    from += count;
  }
}

}  // namespace stroma::python
