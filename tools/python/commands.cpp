// SPDX-License-Identifier: LGPL-2.1-or-later
// What SOFA's calls and the command in the interpreter (tools/python/sofa_compat) need of this module: a session and scenes made of
// Python objects, which cross as capsules, and what the dialect knows of types.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "tools/python/engine.h"
#include "tools/sofa/rewriting.h"

namespace stroma::python {
namespace {

Session& sessionIn(const py::capsule& capsule) { return *capsule.get_pointer<Session>(); }

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Puts every node of a state there, also those that constraints hold: in SOFA they only take velocities away. `x` as
/// state.set() has taken it.
void placeHeld(const std::shared_ptr<Engine>& engine, const std::string& path, const Array& x) {
  for (const auto& system : engine->between().systems())
    for (const State* state : system->states()) {
      if (state->path() != path || state->firstRow() >= system->independentRows()) continue;
      const py::ssize_t width = state->hasFrames() ? 7 : state->hasPointsOnly() ? 3 : state->rows_per_node;
      if (x.ndim() != 2 || x.shape(0) != state->nodes() || x.shape(1) != width) throw py::value_error("an array of another shape");
      const Rows rows = system->x.rows();
      for (Index node = 0; node < state->nodes(); ++node) {
        const double* from = x.data() + py::ssize_t(node) * width;
        double* to = rows.data + std::size_t(state->firstRow() + node * state->rows_per_node) * row_doubles;
        if (state->hasPointsOnly()) {
          std::copy_n(from, 3, to);
        } else if (state->hasFrames()) {
          std::copy_n(from, 3, to), std::copy_n(from + 3, 4, to + row_doubles);
        } else {
          for (py::ssize_t c = 0; c < width; ++c) to[std::size_t(c) * row_doubles] = from[c];
        }
      }
      system->applyMappings();
    }
}

}  // namespace

void bindCommands(py::module_& module) {
  module.def("description", [](const py::tuple& root, const std::string& file, const std::vector<std::string>& files) {
    auto description = std::make_unique<SceneDescription>(descriptionOf(root, file));
    description->files = files;  // that were read
    return py::capsule(description.release(), "stroma::SceneDescription", [](PyObject* capsule) {
      delete static_cast<SceneDescription*>(PyCapsule_GetPointer(capsule, "stroma::SceneDescription"));
    });
  });
  module.def("prepare", [](const py::capsule& session) {
    Factory& factory = sessionIn(session).factory();
    if (!factory.find("PythonForceField")) registerPlayed(factory);
  });
  // what the dialect makes of a type of SOFA
  module.def("sofa_type", [](const std::string& type) { return std::string(sofa::typeHere(type)); });
  module.def("sofa_accepts", [](const std::string& type) { return sofa::isAcceptedType(type); });
  module.def("place_held", &placeHeld);
  module.def("adopt", [](const py::capsule& session) { return std::make_shared<Engine>(sessionIn(session)); });
}

}  // namespace stroma::python
