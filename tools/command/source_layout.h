// SPDX-License-Identifier: LGPL-2.1-or-later
// Comments and blank lines of a scene's files, by the elements that follow them: for rewriting the scene.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "framework/scene/description.h"

namespace stroma::command {

class SourceLayout {
 public:
  explicit SourceLayout(const SceneDescription& scene);

  /// The comments before an element, and an empty string for a blank line; each once. Those of elements that are no longer in the
  /// scene come before the next one that is.
  std::vector<std::string> before(const SourceLocation& where);
  /// Those before the end of a node.
  std::vector<std::string> atEnd(const SourceLocation& node);
  /// Whether a stands before b in the same file.
  static bool precedes(const SourceLocation& a, const SourceLocation& b) {
    return a.file == b.file && std::pair(a.line, a.column) < std::pair(b.line, b.column);
  }

 private:
  using Place = std::pair<int, int>;  ///< line and column of a tag, from 1
  struct Tag {
    Place parent;
    std::vector<std::string> lines;  ///< before it
  };
  struct File {
    std::map<Place, Tag> tags;
    std::map<Place, std::vector<std::string>> ends;  ///< before the end of a tag
    std::set<Place> kept;
  };
  static void scan(const std::string& text, File& file);
  void keep(const NodeDescription& node);
  void passOn(File& file);

  std::map<std::string, File> files_;
};

}  // namespace stroma::command
