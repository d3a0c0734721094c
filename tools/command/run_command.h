// SPDX-License-Identifier: LGPL-2.1-or-later
// The command but for its start. `run` and `picture`, all that a first scene needs, are in the program. All subcommands are in
// the library `commands` beside the modules, which the program opens for the others: who only runs scenes neither compiles nor
// loads them.
#pragma once
#include <functional>

#include "tools/command/command.h"

namespace stroma::command {

/// What `work` returns. An exception becomes a sentence on standard error and an exit code.
int tellErrors(const std::function<int()>& work);

/// Any subcommand by its name, and what `stroma` says of itself.
int runCommand(const Arguments& arguments);

/// The service of the library.
class Commands {
 public:
  static constexpr const char *role = "set of subcommands", *library = "commands", *missing = "build it with `ninja commands`";

  virtual ~Commands() = default;
  /// runCommand() with the library's own state of long work.
  virtual int call(const Arguments& arguments) = 0;
};

}  // namespace stroma::command
