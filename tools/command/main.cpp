// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma`: the start of the command, as a program.
#include <stdlib.h>  // setenv

#include <csignal>
#include <cstdlib>

#include "framework/scene/services.h"
#include "tools/command/long_work.h"
#include "tools/command/python_scene.h"
#include "tools/command/run_command.h"
#include "tools/platform/heap.h"

using namespace stroma::command;

int main(int count, char** values) {
  stroma::reserveHeap(std::size_t{2000} << 20);
  // OpenBLAS would start a thread for every core when a module opens it, and let them spin; factorisations use one
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no more is an error of its writer, not the end of the process
  const Arguments arguments(values + 1, values + count);
  if (needsPython(arguments)) return goOnInPython(arguments);
  for (const Subcommand* here : {&run_command, &picture_command})
    if (!arguments.empty() && arguments[0] == here->name) {
      tellLongWork(true);
      return tellErrors([&] { return here->call({arguments.begin() + 1, arguments.end()}); });
    }
  return tellErrors([&] { return stroma::service<Commands>()->call(arguments); });
}
