// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in the dialect of another program. Such a scene is rewritten as a native one before any component is made: every
// difference in meaning becomes an attribute, and no component knows the dialect. Implemented in tools/sofa.
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// An attribute of the root node; scenes that are foreign by their file name get it.
inline constexpr const char* dialect_attribute = "dialect";
inline constexpr const char* foreign_dialect = "sofa";
inline constexpr const char* dialect_note = "/.dialect";

/// Decided by the attribute `dialect` of the root node, its override, or the file's extension.
bool isForeign(const std::string& file, const NodeDescription& root, const std::vector<Override>& overrides);
/// In such a scene text that is not UTF-8 is read as Latin-1, with a warning; native scenes are left alone.
void decodeForeign(std::string& text, const std::string& file, bool is_foreign, Diagnostics& diagnostics);
/// Whether a type that is known here names a file of components in such a scene, where there is one.
bool isPrefabAbroad(const std::string& type);
/// Rewrites `scene` in place if its root node names the dialect; native scenes are left alone. What is accepted without effect
/// is listed in `no_effect`. A note at the path dialect_note lists the quirks of the other program that the scene now uses.
void rewriteForeign(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
                    std::vector<std::string>& no_effect);

}  // namespace stroma
