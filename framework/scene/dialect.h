// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in the dialect of another program. Such a scene is rewritten as a native one before any component is made: what
// the other program means otherwise is then written in attributes, and no component asks. tools/sofa answers.
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// Of the outermost node; a scene that is foreign by the name of its file gets it.
inline constexpr const char* dialect_attribute = "dialect";
inline constexpr const char* foreign_dialect = "sofa";
inline constexpr const char* dialect_note = "/.dialect";

/// By the attribute `dialect` of the outermost node, the override of it, or the ending of the file.
bool isForeign(const std::string& file, const NodeDescription& root, const std::vector<Override>& overrides);
/// A text that is no UTF-8 is Latin-1 in such a scene, with a warning; the text of a native one stays.
void decodeForeign(std::string& text, const std::string& file, bool is_foreign, Diagnostics& diagnostics);
/// Whether a type that is known here names a file of components in such a scene, where there is one.
bool isPrefabAbroad(const std::string& type);
/// Rewrites `scene` in place where its outermost node names the dialect; a native scene stays. What was accepted is named in
/// `no_effect`. A note at the path dialect_note says which ways of the other program the scene has now.
void rewriteForeign(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
                    std::vector<std::string>& no_effect);

}  // namespace stroma
