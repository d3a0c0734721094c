// SPDX-License-Identifier: LGPL-2.1-or-later
// A Python object that a component calls, found by the number that its attribute `played` holds (stroma/played.py).
#pragma once
#include <pybind11/numpy.h>

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

}  // namespace stroma::python
