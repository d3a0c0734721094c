// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma`: the start of the command, as a program.
#include <malloc.h>
#include <stdlib.h>  // setenv
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>

#include "framework/scene/services.h"
#include "tools/command/long_work.h"
#include "tools/command/python_scene.h"
#include "tools/command/run_command.h"

using namespace stroma::command;

namespace {

/// The heap begins with addresses on huge pages, where the kernel gives them, and what is freed stays in it: to touch new memory in
/// small pages costs more than to make a matrix in it. Addresses alone take no memory.
void reserveHeap() {
#ifdef M_TOP_PAD
  constexpr int megabyte = 1 << 20, reserve = 256 * megabyte, later = 16 * megabyte;
  constexpr std::uintptr_t huge_page = 2 * megabyte;
  mallopt(M_MMAP_THRESHOLD, 32 * megabyte);  // the most that it takes
  mallopt(M_TRIM_THRESHOLD, 2 * reserve);
  mallopt(M_TOP_PAD, reserve);
  const auto first = (reinterpret_cast<std::uintptr_t>(sbrk(0)) + huge_page - 1) / huge_page * huge_page;
  void* volatile grown = std::malloc(megabyte);
  std::free(grown);
  const auto end = reinterpret_cast<std::uintptr_t>(sbrk(0));
  if (end > first) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  mallopt(M_TOP_PAD, later);
#endif
}

}  // namespace

int main(int count, char** values) {
  reserveHeap();
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
