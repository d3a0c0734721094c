// SPDX-License-Identifier: LGPL-2.1-or-later
// The extension `stroma._stroma`: what the Python files of the package `stroma` are built on.
#include "tools/python/python.h"

#include "framework/algebra/parallel.h"
#include "tools/platform/heap.h"
#include "tools/python/termination.h"
#include "tools/session/thread_choice.h"

PYBIND11_MODULE(_stroma, module) {
  using namespace stroma::python;
  module.doc() = "The engine, for the Python files of the package stroma.";
  if (!getenv("GLIBC_TUNABLES")) stroma::reserveHeap(std::size_t{256} << 20);  // else somebody has chosen
  standBeforeMetis();
  bindErrors(module);
  bindCatalogue(module);
  bindTree(module);
  bindEngine(module);
  bindStates(module);
  bindMatrices(module);
  bindView(module);
  bindPictures(module);
  bindRecordings(module);
  bindCommands(module);
  bindGoOn(module);
  module.def("threads", &stroma::threads);
  module.def("set_threads", [](int count) {
    if (count < 1 || count > 1024) throw py::value_error("expected 1 to 1024 threads");
    stroma::giveThreads(count);
  });
  module.def("choose_threads", &stroma::chooseThreads);
  stroma::chooseThreads(true);
  module.attr("version") = STROMA_VERSION;
}
