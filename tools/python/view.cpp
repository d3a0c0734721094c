// SPDX-License-Identifier: LGPL-2.1-or-later
// The live view of a simulation that Python holds, and its page as a file.
#include "tools/view/viewer.h"

#include <pybind11/stl.h>

#include <csignal>

#include "framework/scene/services.h"
#include "tools/python/engine.h"

namespace stroma::python {
namespace {

/// Puts back what SIGINT and SIGTERM did before: the view listens to them itself.
class KeptSignals {
 public:
  KeptSignals() { sigaction(SIGINT, nullptr, &interrupt_), sigaction(SIGTERM, nullptr, &terminate_); }
  ~KeptSignals() { sigaction(SIGINT, &interrupt_, nullptr), sigaction(SIGTERM, &terminate_, nullptr); }
  KeptSignals(const KeptSignals&) = delete;

 private:
  struct sigaction interrupt_, terminate_;
};

/// Calls functions of a program with the simulation `owner`, from whatever thread steps; nothing where there are none.
std::function<void()> calls(const std::shared_ptr<Engine>& engine, const py::list& functions, const py::object& owner) {
  if (functions.size() == 0) return {};
  return [&engine, &functions, &owner] {
    const py::gil_scoped_acquire lock;
    const InUse used(*engine);  // the thread of the view, until its functions have returned
    for (std::size_t i = 0; i < functions.size(); ++i) functions[i](owner);
  };
}

/// The same where nobody could catch what they throw as it is: a thread of the view.
std::function<void()> watchedCalls(const std::shared_ptr<Engine>& engine, const py::list& functions,
                                   const py::object& owner) {
  auto called = calls(engine, functions, owner);
  if (!called) return {};
  return [called = std::move(called)] {
    const py::gil_scoped_acquire lock;
    try {
      called();
    } catch (const py::error_already_set& error) {
      throw std::runtime_error(error.what());
    }
  };
}

/// Serves pages until Ctrl-C; `opened` is called with the address. Returns why the run ended by itself, or nothing.
std::string serve(const std::shared_ptr<Engine>& engine, const std::string& host, int port, double fps, bool at_once,
                  bool paused, const std::vector<std::string>& framed_by, const py::function& opened, const py::list& before,
                  const py::list& after, const py::object& owner) {
  engine->between();
  const auto viewer = service<view::Viewer>();
  std::string reason;
  view::ViewRequest request;
  request.framed_by = framed_by;
  request.host = host, request.port = port, request.fps = fps, request.at_once = at_once, request.paused = paused;
  request.build = buildIdentity();
  request.opened = [&](const std::string& address) {
    const py::gil_scoped_acquire lock;
    opened(address);
  };
  request.before_step = watchedCalls(engine, before, owner), request.after_step = watchedCalls(engine, after, owner);
  request.output_failed = request.ended = [&](const std::string& sentence) { reason = sentence; };
  {
    const KeptSignals kept;
    const InUse used(*engine);
    const py::gil_scoped_release unlocked;
    viewer->view(engine->session(), request);
  }
  engine->forcesAreOld();            // a page may have moved or reset it
  engine->session().withdrawStop();  // the one that has ended it
  return reason;
}

RunReport writePage(const std::shared_ptr<Engine>& engine, const std::string& file, long steps, long every,
                    const std::vector<std::string>& fields, bool inside, const py::list& before, const py::list& after,
                    const py::object& owner) {
  engine->between();
  view::ExportRequest request;
  request.file = file, request.steps = steps, request.every = every, request.fields = fields, request.inside = inside;
  request.before_step = calls(engine, before, owner), request.after_step = calls(engine, after, owner);
  const auto viewer = service<view::Viewer>();
  const InUse used(*engine);
  const py::gil_scoped_release unlocked;
  return viewer->writePage(engine->session(), request);
}

}  // namespace

void bindView(py::module_& module) {
  module.def("serve", &serve);
  module.def("write_page", &writePage);
}

}  // namespace stroma::python
