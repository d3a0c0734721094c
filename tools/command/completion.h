// SPDX-License-Identifier: LGPL-2.1-or-later
// What may stand where the cursor is: the answer to a shell that asks `stroma __complete WORD...`.
#pragma once
#include <string>
#include <vector>

#include "tools/command/options.h"

namespace stroma::command {

/// One answer. A shell shows those whose text begins with what has been typed.
struct Candidate {
  enum class Kind {
    word,   ///< the whole word
    start,  ///< its beginning: no blank follows
    files,  ///< the shell looks for files that fit the patterns in `text` ("*.xml *.scn"; "*": any), and for folders
    folders,
  };
  std::string text, description;
  Kind kind = Kind::word;
};

/// `words` are those after `stroma`, the last one the word at the cursor, which may be empty. Never throws.
std::vector<Candidate> complete(const std::vector<std::string>& words);

/// What may stand for the value called `name` in help: "FILE.html", "bash|zsh".
std::vector<Candidate> candidatesFor(const std::string& name);

/// What may follow --set: paths of the scene in `file`, then attributes of the component, then its choices. Opens no
/// module but the one that has the component. Nothing for a scene that cannot be read.
std::vector<Candidate> settings(const std::string& file, const std::string& typed);

/// The script of bash, zsh or fish, or nothing.
std::string_view completionScript(std::string_view shell);

}  // namespace stroma::command
