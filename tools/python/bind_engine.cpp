// SPDX-License-Identifier: LGPL-2.1-or-later
// Simulations for Python: loading, stepping, attributes of what runs, forces from outside.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "framework/mechanics/force_field.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/live_edit.h"
#include "tools/checks/result_doubts.h"
#include "tools/plan/plan.h"
#include "tools/python/engine.h"
#include "tools/session/action_file.h"

namespace stroma::python {
namespace {

using Ref = const std::shared_ptr<Engine>&;

const char* wordFor(RunEnd end) {
  switch (end) {
    case RunEnd::done: return "done";
    case RunEnd::stopped: return "stopped";
    case RunEnd::diverged: return "diverged";
    case RunEnd::mesh_refused: return "mesh not changed";
    case RunEnd::not_converged: return "not converged";
    case RunEnd::not_replayed: return "not replayed";
    case RunEnd::program_failed: return "program failed";
    case RunEnd::output_failed: return "output failed";
  }
  return "";
}

Data& dataOf(const Engine& engine, const std::string& path, const std::string& attribute) {
  engine.use();  // which no other thread may do while it steps
  Component& component = engine.component(path);
  if (Data* data = component.data().find(attribute)) return *data;
  throw ComponentError(component.type() + " has no attribute '" + attribute + "'",
                       "one of those that 'stroma doc " + component.type() + "' lists",
                       nearest(attribute, component.data().names()));
}

/// What is refused is told with the place of what it concerns.
py::list setAttribute(Ref engine, const std::string& path, const std::string& attribute, const py::object& value) {
  Simulation& simulation = engine->between();
  try {
    const Diagnostics told = simulation.setAttribute(path, attribute, textOf(value));
    engine->forcesAreOld();
    return problemsOf(told);
  } catch (const ComponentError& refused) {
    const Component* component = findComponent(simulation.root(), path);
    const bool has_path = std::string_view(refused.what()).starts_with("/") || !component;
    Diagnostics one;
    one.error(component ? component->where() : SourceLocation{}, has_path ? std::string() : component->path(), refused.what(),
              refused.expected, refused.suggestion);
    if (dynamic_cast<const LiveEdit::NeedsLoad*>(&refused)) raiseLoadNeeded(one);
    throw SceneError(std::move(one));
  }
}

py::object nodeValue(Ref engine, const std::string& path, const std::string& attribute) {
  Node* node = &engine->use().root();
  std::string_view rest = path;
  for (rest.remove_prefix(rest.starts_with("/")); node && !rest.empty();) {
    const auto slash = std::min(rest.size(), rest.find('/'));
    node = node->findChild(rest.substr(0, slash));
    rest.remove_prefix(std::min(rest.size(), slash + 1));
  }
  if (!node) throw ComponentError("the scene has no node " + path);
  Vec3 gravity = node->gravity();
  double dt = node->dt();
  if (attribute == "gravity") return valueOf(Data("gravity", &gravity));
  if (attribute == "dt") return valueOf(Data("dt", &dt));
  throw ComponentError("a node has no attribute '" + attribute + "'", "gravity or dt", nearest(attribute, {"gravity", "dt"}));
}

py::list componentsOf(Ref engine) {
  std::vector<Component*> all;
  engine->simulation().root().collect(all);
  py::list out;
  for (const Component* each : all)
    out.append(py::make_tuple(each->path(), each->type(), each->name(), each->roleText(), each->where().file, each->where().line));
  return out;
}

void collectNodes(const Node& node, py::list& out) {
  out.append(py::make_tuple(node.path(), node.name()));
  for (const auto& child : node.children()) collectNodes(*child, out);
}

Input inputOf(const std::string& state, const std::vector<Index>& nodes, const std::array<double, 3>& force,
              const std::vector<std::array<double, 3>>& targets, double stiffness, double damping) {
  Input input;
  input.state = state;
  input.nodes = nodes;
  input.force = Vec3(force[0], force[1], force[2]);
  for (const auto& target : targets) input.targets.emplace_back(target[0], target[1], target[2]);
  input.stiffness = stiffness;
  input.damping = damping;
  return input;
}

/// Cells and points that go and come, by the word of a kind ("tetrahedra"): see MeshChange.
std::vector<std::string> changeMesh(Ref engine, const std::string& topology, const std::string& kind, const std::vector<Index>& removed,
                                    const std::vector<std::vector<Index>>& added, long points, bool keeps_points) {
  MeshChange change{nullptr, nullptr, removed, added, {}, keeps_points};
  for (const CellKind* each : cell_kinds::all)
    if (each->plural == kind) change.kind = each;
  if (!change.kind) throw ComponentError("there are no cells '" + kind + "'");
  change.points.resize(std::size_t(std::max(0L, points)));
  return engine->changeMesh(topology, std::move(change));
}

py::array cellField(Ref engine, const std::string& path, const std::string& name) {
  const auto* field = dynamic_cast<const ForceField*>(&engine->component(path));
  if (!field) throw ComponentError(path + " is no force field and has no fields of cells");
  const std::vector<std::string> names = field->cellFields();
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw ComponentError(path + " has no field '" + name + "' of cells", {}, nearest(name, names));
  engine->use().complete();
  std::vector<double> values;
  for (const auto& system : engine->simulation().systems()) {
    const auto& own = system->forceFields();
    if (std::find(own.begin(), own.end(), field) != own.end()) field->cellField(name, system->x, values);
  }
  const auto width = py::ssize_t(field->cellFieldShape(name).width), count = py::ssize_t(values.size()) / width;
  if (width == 1) return py::array_t<double>(count, values.data());
  return py::array_t<double>({count, width}, values.data());
}

void bindReports(py::module_& module) {
  py::class_<StepReport>(module, "StepReport", "What a step did.")
      .def_readonly("diverged", &StepReport::diverged, "True: the step has no result, and the states are those before it.")
      .def_readonly("stopped", &StepReport::stopped, "True: request_stop() gave it up.")
      .def_readonly("unsolved", &StepReport::unsolved, "True: no equilibrium was found.")
      .def_readonly("reason", &StepReport::reason, "Why, in a sentence; empty where all is well.")
      .def_readonly("newton_iterations", &StepReport::newton_iterations, "Zero where no Newton method ran.")
      .def_readonly("linear_iterations", &StepReport::linear_iterations,
                    "Over all linear solves of the step; one by factors counts as one.")
      .def_readonly("factorisations", &StepReport::factorisations, "Of matrices.")
      .def_readonly("solve_seconds", &StepReport::solve_seconds, "Wall time of the linear solves, with their products and assembly [s].")
      .def_readonly("linear_residual", &StepReport::linear_residual, "That of the last linear solve, relative to its right side.")
      .def_readonly("linear_converged", &StepReport::linear_converged, "Whether every linear solve ended at its tolerance.")
      .def_readonly("newton_residual", &StepReport::newton_residual, "Relative, where a Newton method ran.")
      .def_readonly("newton_converged", &StepReport::newton_converged, "Whether every search for an equilibrium ended at its tolerance.")
      .def_readonly("constraints_converged", &StepReport::constraints_converged, "Whether every constraint of positions holds.")
      .def_readonly("constraint_reason", &StepReport::constraint_reason, "Which does not, in a sentence; else empty.")
      .def("__repr__", [](const StepReport& r) {
        const std::string reason = r.reason.empty() ? r.constraint_reason : r.reason;
        return fmt::format("<step: {}{}, {} Newton and {} linear iterations, {} factorisations>",
                           r.diverged ? "diverged" : r.stopped ? "stopped" : r.unsolved ? "not solved" : "done",
                           reason.empty() ? "" : " (" + reason + ")", r.newton_iterations, r.linear_iterations, r.factorisations);
      });
  py::class_<RunReport>(module, "RunReport", "How a run ended.")
      .def_property_readonly("end", [](const RunReport& report) { return wordFor(report.end); },
                             "\"done\", \"stopped\", \"diverged\", \"not converged\", \"mesh not changed\" or \"output failed\".")
      .def_readonly("last", &RunReport::last, "The StepReport of the last step.")
      .def_readonly("reason", &RunReport::reason, "Why it ended, in a sentence; empty where it was done.")
      .def_readonly("seconds", &RunReport::seconds, "Wall time [s].")
      .def_property_readonly("steps", [](const RunReport& report) { return report.statistics.step_ms.size(); }, "How many were made.")
      .def_property_readonly("step_ms",
                             [](const RunReport& report) {
                               const std::vector<double>& ms = report.statistics.step_ms;
                               return py::array_t<double>(py::ssize_t(ms.size()), ms.data());
                             },
                             "The wall time of each step, (steps,) [ms].")
      .def_property_readonly("linear_iterations", [](const RunReport& r) { return r.statistics.linear_iterations; }, "Of all steps.")
      .def_property_readonly("newton_iterations", [](const RunReport& r) { return r.statistics.newton_iterations; }, "Of all steps.")
      .def_property_readonly("factorisations", [](const RunReport& r) { return r.statistics.factorisations; }, "Of all steps.")
      .def_property_readonly("warnings", [](const RunReport& r) { return r.statistics.unconverged.warnings(); },
                             "Sentences on solves that did not converge.")
      .def("__repr__", [](const RunReport& r) {
        const std::size_t steps = r.statistics.step_ms.size(), warnings = r.statistics.unconverged.warnings().size();
        return fmt::format("<run of {} {}: {}{}, {:.3g} s{}>", steps, steps == 1 ? "step" : "steps", wordFor(r.end),
                           r.reason.empty() ? "" : " (" + r.reason + ")", r.seconds,
                           warnings == 0 ? "" : fmt::format(", {} {}", warnings, warnings == 1 ? "warning" : "warnings"));
      });
}

}  // namespace

using EngineClass = py::class_<Engine, std::shared_ptr<Engine>>;

static void bindRuns(EngineClass& engine) {
  engine
      .def_static("of_file",
                  [](const std::string& file, const py::list& overrides, bool observed) {
                    return Engine::ofFile(file, overridesOf(overrides), observed);
                  })
      .def_static("of_tree",
                  [](const py::tuple& root, const std::string& file, const py::list& overrides, bool observed) {
                    return Engine::ofTree(root, file, overridesOf(overrides), observed);
                  })
      .def("copy", &Engine::copy)
      .def("run", &Engine::run)
      .def("request_stop", [](Engine& self) { self.session().requestStop(); })
      .def("end_after_step", &Engine::endAfterStep)
      .def_property_readonly("time", [](Ref self) { return self->simulation().time(); })
      .def_property_readonly("dt", [](Ref self) { return self->simulation().dt(); })
      .def_property_readonly("steps", [](Ref self) { return self->simulation().steps(); })
      .def_property_readonly("scene_file", [](Ref self) { return self->session().sceneFile(); })
      .def("hash", [](Ref self) { return self->between().stateHash(); })
      .def("reset", &Engine::reset)
      .def("finish", [](Ref self) { self->between().end(); })
      .def("checkpoint",
           [](Ref self) {
             self->between();
             return py::bytes(self->checkpoint().bytes());
           })
      .def("restore",
           [](Ref self, const std::string& bytes) {
             self->between();
             return self->restore(Checkpoint::fromBytes(bytes, "the checkpoint"));
           })
      .def("problems", [](Ref self) { return problemsOf(self->simulation().scene().diagnostics); })
      .def_property_readonly("doubts", [](Ref self) { return doubtsOf(self->use()); })
      .def("no_effect", [](Ref self) { return self->simulation().scene().no_effect; })
      .def("plan", [](Ref self) { return planOf(self->use()).lines(); })
      .def("actions",
           [](Ref self) { return printActions({self->session().sceneFile(), self->use().events()}); })
      .def("energies", [](Ref self) {
        const Energies energies = energiesOf(self->use());
        py::dict out;
        out["kinetic"] = energies.kinetic, out["elastic"] = energies.elastic, out["gravity"] = energies.gravity;
        return out;
      });
}

static void bindParts(EngineClass& engine) {
  engine.def("components", &componentsOf)
      .def("nodes",
           [](Ref self) {
             py::list out;
             collectNodes(self->simulation().root(), out);
             return out;
           })
      .def(
          "get",
          [](Ref self, const std::string& path, const std::string& attribute, bool found) {
            return valueOf(dataOf(*self, path, attribute), found);
          },
          py::arg("path"), py::arg("attribute"), py::arg("found") = false)
      .def("node_value", &nodeValue)
      .def("info", [](Ref self, const std::string& path, const std::string& attribute) { return infoOf(dataOf(*self, path, attribute)); })
      .def("attributes",
           [](Ref self, const std::string& path) {
             std::vector<std::string> names;
             for (const Data& data : self->component(path).data().all()) names.push_back(data.name());
             return names;
           })
      .def("set", &setAttribute)
      .def_property_readonly("mesh_changes", [](Ref self) { return self->session().meshChanges(); })
      .def("watch_solves", &Engine::watchSolves)
      .def("change_mesh", &changeMesh)
      .def("edits",
           [](Ref self) {
             py::list out;
             for (const Override& edit : self->use().edits())
               out.append(py::make_tuple(edit.path, edit.attribute, edit.value));
             return out;
           })
      .def("cell_fields",
           [](Ref self, const std::string& path) {
             const auto* field = dynamic_cast<const ForceField*>(&self->component(path));
             return field ? field->cellFields() : std::vector<std::string>();
           })
      .def("cell_field", &cellField)
      .def("cell_field_kind",
           [](Ref self, const std::string& path, const std::string& name) {
             const auto* field = dynamic_cast<const ForceField*>(&self->component(path));
             const CellKind* kind = field ? field->cellFieldShape(name).kind : nullptr;
             return std::string(kind ? kind->singular : "");
           });
}

static void bindInputs(EngineClass& engine) {
  engine
      .def("add_input",
           [](Ref self, const std::string& state, const std::vector<Index>& nodes, const std::array<double, 3>& force,
              const std::vector<std::array<double, 3>>& targets, double stiffness, double damping) {
             const long number = self->between().addInput(inputOf(state, nodes, force, targets, stiffness, damping));
             self->forcesAreOld();
             return number;
           })
      .def("change_input",
           [](Ref self, long number, const std::string& state, const std::vector<Index>& nodes,
              const std::array<double, 3>& force, const std::vector<std::array<double, 3>>& targets, double stiffness,
              double damping) {
             self->between().changeInput(number, inputOf(state, nodes, force, targets, stiffness, damping));
             self->forcesAreOld();
           })
      .def("remove_input", [](Ref self, long number) {
        self->between().removeInput(number);
        self->forcesAreOld();
      });
}

void bindEngine(py::module_& module) {
  bindReports(module);
  EngineClass engine(module, "Engine");
  bindRuns(engine);
  bindParts(engine);
  bindInputs(engine);
}

}  // namespace stroma::python
