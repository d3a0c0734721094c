// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/completion.h"
#include "tools/platform/text_file.h"

STROMA_TEXT_FILE(stroma_bash_script, STROMA_SOURCE "/tools/command/shell/stroma.bash")
STROMA_TEXT_FILE(stroma_zsh_script, STROMA_SOURCE "/tools/command/shell/_stroma")
STROMA_TEXT_FILE(stroma_fish_script, STROMA_SOURCE "/tools/command/shell/stroma.fish")

namespace stroma::command {

std::string_view completionScript(std::string_view shell) {
  if (shell == "bash") return stroma_bash_script();
  if (shell == "zsh") return stroma_zsh_script();
  return shell == "fish" ? stroma_fish_script() : std::string_view();
}

}  // namespace stroma::command
