// SPDX-License-Identifier: LGPL-2.1-or-later
// The whole command in an interpreter, for scenes in Python: the module `stroma._command`.
//
//   main(words, program) -> exit code
//
// `program` plays the scene (tools/session/scene_program.h): describe(file, session) returns a description as a capsule,
// loaded(session) gets the session as a capsule, before_step() and after_step() are called between steps. The interpreter's
// lock is free while the command works.
#include <errno.h>  // program_invocation_name
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <tuple>
#include <vector>

#include "tools/command/long_work.h"
#include "tools/command/run_command.h"
#include "tools/session/scene_program.h"
#include "tools/session/session.h"

namespace py = pybind11;

namespace stroma {
namespace {

class Played : public SceneProgram {
 public:
  explicit Played(py::object program) : program_(std::move(program)) {}

  SceneDescription describe(const std::string& file, Session& session) override {
    return inPython([&] {
      const py::capsule made = program_.attr("describe")(file, capsuleOf(session));
      const std::unique_ptr<SceneDescription> description(made.get_pointer<SceneDescription>());
      if (PyCapsule_SetDestructor(made.ptr(), nullptr) != 0) throw py::error_already_set();
      return std::move(*description);
    });
  }
  void loaded(Session& session) override {
    inPython([&] { program_.attr("loaded")(capsuleOf(session)); });
  }
  void beforeStep(Simulation&) override {
    inPython([&] { program_.attr("before_step")(); });
  }
  void afterStep(Simulation&) override {
    inPython([&] { program_.attr("after_step")(); });
  }
  void key(const std::string& name, bool pressed) override {
    inPython([&] { program_.attr("key")(name, pressed); });
  }
  void mouse(const Mouse& mouse) override {
    inPython([&] { program_.attr("mouse")(mouse.state, mouse.x, mouse.y, mouse.wheel); });
  }

 private:
  static py::capsule capsuleOf(Session& session) { return py::capsule(&session, "stroma::Session"); }
  /// With the interpreter's lock; what Python raises becomes the sentence that `program` makes of it.
  template <class Call>
  auto inPython(Call&& call) -> decltype(call()) {
    const py::gil_scoped_acquire lock;
    try {
      return call();
    } catch (py::error_already_set& error) {
      throwProblems(error.value());
      throw ProgramError(program_.attr("sentence")(error.value()).cast<std::string>());
    }
  }

  /// What is wrong with the file, if it is that.
  void throwProblems(const py::object& error) {
    const py::object problems = program_.attr("problems")(error);
    if (problems.is_none()) return;
    Diagnostics diagnostics;
    for (const auto& [file, line, text] : problems.cast<std::vector<std::tuple<std::string, int, std::string>>>())
      diagnostics.error({file, line, 0}, {}, text);
    throw SceneError(std::move(diagnostics));
  }

  py::object program_;
};

int runWithProgram(const std::vector<std::string>& words, const py::object& program) {
  std::signal(SIGXFSZ, SIG_IGN);
  if (char* name = std::getenv("STROMA_COMMAND_NAME")) program_invocation_name = name;  // what messages tell to call
  setSceneProgram(std::make_unique<Played>(program));
  int code = 0;
  {
    const py::gil_scoped_release unlocked;
    command::tellLongWork(true);
    code = command::runCommand(words);
  }
  setSceneProgram(nullptr);
  std::fflush(nullptr);  // the interpreter may end without the library's buffers
  return code;
}

}  // namespace
}  // namespace stroma

PYBIND11_MODULE(_command, module) {
  module.doc() = "The command `stroma` in an interpreter, for scenes in Python.";
  module.def("main", &stroma::runWithProgram, py::arg("words"), py::arg("program"));
}
