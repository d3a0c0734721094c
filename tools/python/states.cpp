// SPDX-License-Identifier: LGPL-2.1-or-later
// States as arrays. Positions, velocities and forces of points are views of the engine's memory: rows of 32 bytes, of which
// an array shows the three components. A view holds the simulation, so that it never dangles. Frames have two rows each, and
// are copied: 7 numbers of a position (centre, quaternion x y z w), 6 of a velocity or a force (linear, angular).
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/state_topology.h"
#include "framework/simulation/integrator.h"
#include "tools/python/engine.h"
#include "tools/python/played.h"

namespace stroma::python {
namespace {

enum class What { position, velocity, force };

struct StateRef {
  std::shared_ptr<Engine> engine;
  State* first;  ///< before meshes have changed, it lives as long as the engine; null when looked for after that
  std::string path;

  State& state() const {
    const bool is_first = first && !engine->simulation().hasChangedMeshes();
    return is_first ? *first : dynamic_cast<State&>(engine->component(path));
  }
  bool hasPoints() const { return state().hasPointsOnly(); }
  ConstRows rows(What what) const {
    State& own = state();
    if (what == What::force && !own.forceRequested())
      throw ComponentError("the force on " + path + " was not asked for: it takes an evaluation of its own", "request_forces()");
    return what == What::position ? ConstRows(own.x()) : what == What::velocity ? ConstRows(own.v()) : own.f();
  }
};

py::array readOnly(py::array array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// `columns` numbers of each row, in the engine's memory; a copy once meshes have changed, as they may again.
py::array view(const StateRef& self, ConstRows rows, py::ssize_t first_step, std::vector<py::ssize_t> shape) {
  using Shared = std::shared_ptr<Simulation>;
  const bool is_copied = self.engine->simulation().hasChangedMeshes();
  const py::capsule owner(new Shared(self.engine->shared()), [](void* held) { delete static_cast<Shared*>(held); });
  const std::size_t second_step = (self.hasPoints() ? 1 : row_doubles) * sizeof(double);
  std::vector<py::ssize_t> strides{first_step, py::ssize_t(second_step)};
  return readOnly(py::array(py::dtype::of<double>(), std::move(shape), std::move(strides), rows.data,
                            is_copied ? py::handle() : py::handle(owner)));
}

py::array frames(const StateRef& self, ConstRows rows, What what) {
  const py::ssize_t width = what == What::position ? 7 : 6;
  py::array_t<double> out({py::ssize_t(self.state().nodes()), width});
  for (Index node = 0; node < self.state().nodes(); ++node) {
    double* to = out.mutable_data() + node * width;
    const double* from = rows.data + std::size_t(node) * 2 * row_doubles;
    std::copy_n(from, 3, to);
    std::copy_n(from + row_doubles, width - 3, to + 3);
  }
  return readOnly(std::move(out));
}

py::array arrayOf(const StateRef& self, What what) {
  self.engine->use().complete();
  if (what == What::force) self.engine->presentForces();
  const ConstRows rows = self.rows(what);
  const py::ssize_t row = row_doubles * sizeof(double), per_node = self.state().rows_per_node;
  if (self.state().hasFrames()) return frames(self, rows, what);
  if (self.hasPoints()) return view(self, rows, row, {rows.count, 3});
  return view(self, rows, row * per_node, {self.state().nodes(), per_node});
}

/// Initial or rest values as positions() has them.
py::array listed(const StateRef& self, const std::vector<Vec3>& values) {
  Vector rows(Index(values.size()));
  const State& state = self.state();
  for (std::size_t i = 0; i < values.size(); ++i) placeRow(state.kindOf(Index(i)), values[i], rows, Index(i));
  if (self.state().hasFrames()) return frames(self, rows, What::position);
  const py::ssize_t width = self.hasPoints() ? 3 : self.state().rows_per_node;
  py::array_t<double> out({py::ssize_t(self.state().nodes()), width});
  for (Index i = 0; i < rows.count(); ++i)
    for (int c = 0; c < (self.hasPoints() ? 3 : 1); ++c)
      out.mutable_data()[self.hasPoints() ? 3 * i + c : i] = rows.rows().data[std::size_t(i) * row_doubles + std::size_t(c)];
  return readOnly(std::move(out));
}

/// Forces of Lagrangian constraints in the last step, and what mapped states hand up of them.
py::array constraintForces(const StateRef& self) {
  const Systems& systems = self.engine->use().systems();
  const auto system = std::find_if(systems.begin(), systems.end(), [&](const auto& each) {
    const auto& states = each->actors().states;
    return std::find(states.begin(), states.end(), &self.state()) != states.end();
  });
  if (system == systems.end()) throw ComponentError("nothing moves " + self.state().path(), "a state below an integrator");
  Vector all = self.engine->constraintForces(std::size_t(system - systems.begin()));
  if (all.count() == 0) all.resize((*system)->allRows());
  (*system)->mappingChain().pullBack(all);
  const State& state = self.state();
  const ConstRows own = all.rows().segment(state.firstRow(), state.size());
  if (state.hasFrames()) return frames(self, own, What::force);
  const py::ssize_t width = self.hasPoints() ? 3 : state.rows_per_node;
  py::array_t<double> out({py::ssize_t(state.nodes()), width});
  for (Index i = 0; i < own.count; ++i)
    for (int c = 0; c < (self.hasPoints() ? 3 : 1); ++c) out.mutable_data()[self.hasPoints() ? 3 * i + c : i] = own[i][c];
  return readOnly(std::move(out));
}

/// Numbers of Python in rows as the engine has them; none: no rows.
void take(const StateRef& self, const py::object& given, What what, Vector& rows) {
  if (given.is_none()) return;
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(given);
  const py::ssize_t nodes = self.state().nodes();
  const py::ssize_t width = self.state().hasFrames() ? (what == What::position ? 7 : 6) : self.hasPoints() ? 3 : self.state().rows_per_node;
  if (numbers.ndim() != 2 || numbers.shape(0) != nodes || numbers.shape(1) != width)
    throw py::value_error("expected an array of shape (" + std::to_string(nodes) + ", " + std::to_string(width) + ")");
  const State& state = self.state();
  rows.resize(state.size());
  double* out = rows.rows().data;
  for (py::ssize_t node = 0; node < nodes; ++node) {
    const double* from = numbers.data() + node * width;
    double* to = out + std::size_t(node * state.rows_per_node) * row_doubles;
    if (state.hasPointsOnly()) {
      std::copy_n(from, 3, to);
    } else if (state.hasFrames()) {
      std::copy_n(from, 3, to), std::copy_n(from + 3, width - 3, to + row_doubles);
    } else {
      for (py::ssize_t i = 0; i < width; ++i) to[std::size_t(i) * row_doubles] = from[i];
    }
  }
}

Index set(const StateRef& self, const py::object& x, const py::object& v) {
  Simulation& simulation = self.engine->use();
  Vector new_x, new_v;
  take(self, x, What::position, new_x);
  take(self, v, What::velocity, new_v);
  const auto rows = [](const Vector& vector) { return vector.count() > 0 ? vector.rows() : ConstRows(); };
  const Index kept = simulation.setState(self.state(), rows(new_x), rows(new_v));
  self.engine->forcesAreOld();
  return kept;
}

/// Where points are that nothing moves, as those of a tool that a scene places: surfaces on them are there from the next step on.
/// False for what moves, and for others than points.
bool placeStill(const std::shared_ptr<Engine>& engine, const std::string& path, const Array& places) {
  engine->between();
  auto* const state = dynamic_cast<State*>(&engine->component(path));
  if (!state || state->isBound() || !state->hasPointsOnly()) return false;
  if (places.ndim() != 2 || places.shape(0) != py::ssize_t(state->position.size()) || places.shape(1) != 3) return false;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < state->position.size(); ++i) points.emplace_back(places.data() + 3 * i);
  engine->placeStill(path, std::move(points));
  return true;
}

/// Where a state of points or numbers is at rest, for what reads that in each step. False for others.
bool leadRest(const std::shared_ptr<Engine>& engine, const std::string& path, const Array& places) {
  Simulation& simulation = engine->between();
  auto* const state = dynamic_cast<State*>(&engine->component(path));
  if (!state || state->hasFrames()) return false;
  const py::ssize_t width = widthOf(*state, true);
  if (places.ndim() != 2 || places.shape(0) != state->nodes() || places.shape(1) != width) return false;
  for (std::size_t i = 0; i < state->rest_position.size(); ++i)
    state->rest_position[i] = width == 3 && state->hasPointsOnly() ? Vec3(places.data() + 3 * i) : Vec3(places.data()[i], 0, 0);
  for (const auto& system : simulation.systems()) system->integrator().sceneChanged();
  engine->forcesAreOld();
  return true;
}

template <class Cells>
void addCells(py::dict& out, const char* name, const Cells& cells) {
  if (cells.empty()) return;
  constexpr py::ssize_t width = std::tuple_size_v<typename Cells::value_type>;
  out[name] = py::array_t<Index>({py::ssize_t(cells.size()), width}, cells.front().data());
}

/// Cells by the names that meshio and VTK know: "tetra", "hexahedron", ...
py::object meshOf(const StateRef& self) {
  self.engine->use();
  const Topology* topology = topologyOf(self.state());
  if (!topology) return py::none();
  const Mesh& mesh = topology->mesh();
  py::dict cells;
  addCells(cells, "line", mesh.edges);
  addCells(cells, "triangle", mesh.triangles);
  addCells(cells, "quad", mesh.quads);
  addCells(cells, "triangle6", mesh.quadratic_triangles);
  addCells(cells, "tetra", mesh.tetrahedra);
  addCells(cells, "hexahedron", mesh.hexahedra);
  addCells(cells, "wedge", mesh.prisms);
  addCells(cells, "pyramid", mesh.pyramids);
  addCells(cells, "tetra10", mesh.quadratic_tetrahedra);
  py::dict surface;
  addCells(surface, "triangle", mesh.boundaryTriangles());
  addCells(surface, "quad", mesh.boundaryQuads());
  addCells(surface, "triangle6", mesh.boundaryQuadraticTriangles());
  return py::make_tuple(topology->path(), cells, surface);
}

std::vector<StateRef> statesOf(const std::shared_ptr<Engine>& engine) {
  std::vector<StateRef> out;
  const bool changed = engine->simulation().hasChangedMeshes();
  for (State* state : engine->simulation().states()) out.push_back({engine, changed ? nullptr : state, state->path()});
  return out;
}

}  // namespace

void bindStates(py::module_& module) {
  py::class_<StateRef>(module, "State")
      .def_property_readonly("path", [](const StateRef& self) { return self.state().path(); })
      .def_property_readonly("nodes", [](const StateRef& self) { return self.state().nodes(); })
      .def_property_readonly("kind",
                             [](const StateRef& self) {
                               return self.hasPoints() ? "points" : self.state().hasFrames() ? "frames" : "numbers";
                             })
      .def_property_readonly("x", [](const StateRef& self) { return arrayOf(self, What::position); })
      .def_property_readonly("v", [](const StateRef& self) { return arrayOf(self, What::velocity); })
      .def_property_readonly("f", [](const StateRef& self) { return arrayOf(self, What::force); })
      .def_property_readonly("constraint_forces", &constraintForces)
      .def_property_readonly("rest", [](const StateRef& self) { return listed(self, self.state().rest_position); })
      .def_property_readonly("start", [](const StateRef& self) { return listed(self, self.state().position); })
      .def_property_readonly(
          "address", [](const StateRef& self) { return reinterpret_cast<std::uintptr_t>(self.state().x().data); })
      .def("set", &set, py::arg("x") = py::none(), py::arg("v") = py::none())
      .def("mesh", &meshOf);
  module.def("place_still", &placeStill);
  module.def("lead_rest", &leadRest);
  module.def("states_of", &statesOf);
  module.def("request_forces", [](const std::shared_ptr<Engine>& engine) { engine->requestForces(); });
}

}  // namespace stroma::python
