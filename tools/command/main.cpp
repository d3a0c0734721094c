// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma`: finds the subcommand, turns what goes wrong into a sentence and an exit code.
#include <stdlib.h>

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "framework/scene/diagnostics.h"
#include "tools/command/command.h"

namespace {

using namespace stroma::command;

void printHelp(std::FILE* stream) {
  fmt::print(stream, "stroma {}: soft tissue from an XML scene\n\nusage: stroma SUBCOMMAND ...\n\n", STROMA_VERSION);
  for (const Subcommand* subcommand : subcommands())
    if (subcommand->group != Group::hidden) fmt::print(stream, "  {:8} {}\n", subcommand->name, subcommand->purpose);
  fmt::print(
      stream,
      "\n`stroma SUBCOMMAND --help` prints its options and examples.\n"
      "Exit codes: 0 done, 1 a comparison failed, 2 bad input (nothing was run), 3 no result (the last state is\n"
      "written and named), 4 an output could not be written any more, 130 interrupted with Ctrl-C, 143 ended by "
      "SIGTERM.\n");
}

int dispatch(const std::string& name, const Arguments& arguments) {
  if (const Subcommand* subcommand = findSubcommand(name)) return subcommand->call(arguments);
  std::vector<std::string> names;
  for (const Subcommand* subcommand : subcommands())
    if (subcommand->group != Group::hidden) names.emplace_back(subcommand->name);
  const std::string near = stroma::nearest(name, names);
  throw UsageError(fmt::format("there is no subcommand '{}' ({})", name,
                               near.empty() ? fmt::format("expected one of: {}", fmt::join(names, ", "))
                                            : fmt::format("did you mean '{}'?", near)));
}

}  // namespace

int main(int count, char** values) {
  // OpenBLAS would start a thread for every core when a module opens it, and let them spin; factorisations use one
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no more is an error of its writer, not the end of the process
  const Arguments arguments(values + 1, values + count);
  if (arguments.empty()) {
    printHelp(stderr);
    return exit_bad_input;
  }
  if (arguments[0] == "--help" || arguments[0] == "-h" || arguments[0] == "help") {
    printHelp(stdout);
    return exit_done;
  }
  if (arguments[0] == "--version") {
    fmt::print("stroma {}\n", STROMA_VERSION);
    return exit_done;
  }
  try {
    return dispatch(arguments[0], {arguments.begin() + 1, arguments.end()});
  } catch (const stroma::SceneError& error) {
    const int errors = error.diagnostics().errorCount();
    fmt::print(stderr, "{}\n{} error{}: nothing was run\n", error.diagnostics().text(), errors, errors == 1 ? "" : "s");
  } catch (const stroma::ComponentError& error) {
    fmt::print(stderr, "stroma: {}{}\n", error.what(),
               error.expected.empty() ? "" : " (expected " + error.expected + ")");
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "stroma: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "stroma: {}\n", error.what());
  }
  return exit_bad_input;
}
