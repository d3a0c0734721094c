// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma`: the start of the command, as a program.
#include <stdlib.h>

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "tools/command/help.h"
#include "tools/command/long_work.h"
#include "tools/command/python_scene.h"

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
  if (needsPython(arguments)) return goOnInPython(arguments);
  return runCommand(arguments);
}
