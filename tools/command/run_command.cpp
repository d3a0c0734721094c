// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/run_command.h"

#include <fmt/format.h>

#include <cstdio>

#include "framework/scene/diagnostics.h"
#include "tools/session/scene_program.h"

namespace stroma::command {

int tellErrors(const std::function<int()>& work) {
  try {
    return work();
  } catch (const SceneError& error) {
    const int errors = error.diagnostics().errorCount();
    fmt::print(stderr, "{}\n{} error{}: nothing was run\n", error.diagnostics().text(), errors, errors == 1 ? "" : "s");
  } catch (const ComponentError& error) {
    fmt::print(stderr, "stroma: {}{}{}\n", error.what(),
               error.expected.empty() ? "" : " (expected " + error.expected + ")",
               error.suggestion.empty() ? "" : "; did you mean '" + error.suggestion + "'?");
  } catch (const ProgramError& error) {  // begins with its place
    fmt::print(stderr, "{}\n", error.what());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "stroma: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "stroma: {}\n", error.what());
  }
  return exit_bad_input;
}

}  // namespace stroma::command
