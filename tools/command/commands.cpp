// SPDX-License-Identifier: LGPL-2.1-or-later
// The library of all subcommands (run_command.h).
#include "framework/scene/abi.h"
#include "framework/scene/services.h"
#include "tools/command/long_work.h"
#include "tools/command/run_command.h"

namespace stroma::command {
namespace {

class AllCommands final : public Commands {
 public:
  int call(const Arguments& arguments) override {
    tellLongWork(true);
    return runCommand(arguments);
  }
};

}  // namespace
}  // namespace stroma::command

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  using namespace stroma::command;
  static const stroma::ServiceInfo info{STROMA_ABI, Commands::role,
                                        []() -> void* { return static_cast<Commands*>(new AllCommands); }};
  return &info;
}
