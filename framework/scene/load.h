// SPDX-License-Identifier: LGPL-2.1-or-later
// From a file to a tree of initialised components: read, resolve, instantiate, link, initialise.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "framework/scene/description.h"
#include "framework/scene/modules.h"
#include "framework/scene/node.h"

namespace stroma {

/// Limits on the size of a scene: exceeding them is an error, before memory runs out.
struct ReadLimits {
  std::size_t file_bytes = 64u << 20;
  std::size_t attribute_bytes = 16u << 20;
  int depth = 256;
  int include_depth = 32;
};

/// `--set /liver/fem.method=polar`.
struct Override {
  std::string path, attribute, value;
  static Override parse(const std::string& text);  ///< throws std::invalid_argument with a sentence
};

/// Writes them to the current owner of the archive, or reads them.
void visitEdits(Archive& archive, std::vector<Override>& edits);

/// XML text to plain data. Problems go to `diagnostics`; what could be read is returned.
NodeDescription readXml(const std::string& text, const std::string& file, const ReadLimits& limits,
                        Diagnostics& diagnostics);
/// Reads the file, splices includes (cycles are reported), applies the overrides.
SceneDescription readScene(const std::string& file, const std::vector<Override>& overrides, const ReadLimits& limits,
                           Diagnostics& diagnostics);

/// A scene in memory. Owns the tree.
struct Scene {
  std::unique_ptr<Node> root;
  SceneDescription description;
  Diagnostics diagnostics;             ///< warnings and notes of a scene that loaded
  std::vector<std::string> no_effect;  ///< visual-only components and attributes that were accepted
};

/// The whole way. Throws SceneError with every problem found. `check_only` keeps going as far as possible in any case.
Scene loadScene(const std::string& file, const std::vector<Override>& overrides, Factory& factory, Modules& modules,
                const ReadLimits& limits = {});
/// The same from XML text; `name` stands for the file, and relative file names start at its folder.
Scene loadSceneText(const std::string& xml, const std::string& name, const std::vector<Override>& overrides,
                    Factory& factory, Modules& modules, const ReadLimits& limits = {});
/// The same from a description (tests, other front ends).
Scene instantiate(SceneDescription description, Factory& factory, Modules& modules, Diagnostics diagnostics = {});

/// The component at `path` ("/liver/fem", "liver/fem"), or null.
Component* findComponent(Node& root, std::string_view path);

/// Searches `given` as section "files" of the manual says; empty when not found. `searched` lists the folders.
std::string findFile(const std::string& given, const std::string& folder, std::vector<std::string>* searched);

}  // namespace stroma
