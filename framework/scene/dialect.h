// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in the dialect of another program. Such a scene is rewritten as a native one before any component is created:
// differences in meaning become explicit attributes, and no component needs to know the dialect. tools/sofa implements it.
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// Attribute of the outermost node; a scene whose file extension implies a dialect gets it too.
inline constexpr const char* dialect_attribute = "dialect";
inline constexpr const char* foreign_dialect = "sofa";
inline constexpr const char* dialect_note = "/.dialect";

/// By the attribute `dialect` of the outermost node, its override, or the file extension.
bool isForeign(const std::string& file, const NodeDescription& root, const std::vector<Override>& overrides);
/// Text that is not UTF-8 is read as Latin-1 in such a scene, with a warning; native scenes are not converted.
void decodeForeign(std::string& text, const std::string& file, bool is_foreign, Diagnostics& diagnostics);
/// The folders besides those of the environment in which such a scene looks for files.
std::vector<std::string> foreignDataPaths(const std::string& file);
/// Whether a known type is a prefab in such a scene if a file with that name exists.
bool isPrefabAbroad(const std::string& type);
/// Rewrites `scene` in place if its outermost node names the dialect; a native scene is unchanged. `no_effect` lists what was
/// accepted without effect. A note at the path dialect_note lists the quirks that the scene now has.
void rewriteForeign(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
                    std::vector<std::string>& no_effect);

}  // namespace stroma
