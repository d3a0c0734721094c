// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene with what was changed while it ran.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace stroma {

class Simulation;

/// The text of a scene with the edits of a run.
struct ChangedScene {
  /// Of the scene and of every file that it includes, by the names in SceneDescription::files. Those that no edit
  /// concerns are as they were read, to the byte. Empty when the scene was not read from a text.
  std::map<std::string, std::string> texts;
  std::vector<std::string> changed;      ///< the files whose text is another now
  std::vector<std::string> not_written;  ///< a sentence for each edit that is not in the texts: which one, and why
  std::vector<std::string> notes;        ///< what else one has to know: files that changed on disk, overrides
};

/// Writes the attributes that were set in the run (Simulation::setAttribute) into the text of the scene as it was
/// loaded. Only values change, comments and layout stay; an attribute that a file calls by an old name or another
/// accepted one keeps it. An edit of an element of an included file goes to that file, and one of an attribute that the
/// <include> gives goes there. No file is written. Files are read again only to see whether they still are what was
/// loaded.
ChangedScene changedScene(const Simulation& simulation);

}  // namespace stroma
