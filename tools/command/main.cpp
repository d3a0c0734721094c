// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma`: finds the subcommand, turns what goes wrong into a sentence and an exit code.
#include <stdlib.h>

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "framework/scene/diagnostics.h"
#include "tools/command/help.h"
#include "tools/command/long_work.h"

using namespace stroma::command;

int main(int count, char** values) {
  tellLongWork(true);
  // OpenBLAS would start a thread for every core when a module opens it, and let them spin; factorisations use one
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no more is an error of its writer, not the end of the process
  const Arguments arguments(values + 1, values + count);
  if (arguments.empty()) {
    printOverview(stderr);
    return exit_bad_input;
  }
  if (arguments[0] == "--help" || arguments[0] == "-h") {
    printOverview(stdout);
    return exit_done;
  }
  try {
    if (arguments[0] == "--version") return printVersion(), exit_done;
    return subcommandNamed(arguments[0]).call({arguments.begin() + 1, arguments.end()});
  } catch (const stroma::SceneError& error) {
    const int errors = error.diagnostics().errorCount();
    fmt::print(stderr, "{}\n{} error{}: nothing was run\n", error.diagnostics().text(), errors, errors == 1 ? "" : "s");
  } catch (const stroma::ComponentError& error) {
    fmt::print(stderr, "stroma: {}{}{}\n", error.what(),
               error.expected.empty() ? "" : " (expected " + error.expected + ")",
               error.suggestion.empty() ? "" : "; did you mean '" + error.suggestion + "'?");
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "stroma: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "stroma: {}\n", error.what());
  }
  return exit_bad_input;
}
