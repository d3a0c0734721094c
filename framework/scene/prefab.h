// SPDX-License-Identifier: LGPL-2.1-or-later
// SOFA's prefabs: <Leg name="left"/> where there is no component Leg, but a file Objects/Leg.xml in the element's
// folder or on the data path, is <include href="Objects/Leg.xml" name="left"/>.
#pragma once
#include <functional>

#include "framework/scene/load.h"

namespace stroma {

/// True for a type that needs no prefab: a component, known under its present or an old name.
using KnownType = std::function<bool(const std::string& type)>;

/// Like readScene(), with prefabs for unknown types. `text`, if given, replaces the content of `file`.
SceneDescription readSceneWithPrefabs(const std::string& file, const std::vector<Override>& overrides,
                                      const ReadLimits& limits, const KnownType& is_known, Diagnostics& diagnostics,
                                      const std::string* text = nullptr);

/// The types that `factory` and `modules` know without opening any, and those in the change table.
KnownType knownTypes(const Factory& factory, const Modules& modules);

}  // namespace stroma
