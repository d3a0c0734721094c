// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/preview.h"

#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/instantiation.h"

namespace stroma {

Preview::Preview(SceneDescription description, Factory& factory, Modules& modules) {
  scene_.description = std::move(description);
  if (scene_.description.data_paths.empty()) scene_.description.data_paths = environmentDataPaths();
  rewriteForeign(scene_.description, factory, modules, scene_.diagnostics, scene_.no_effect);
  Instantiation(scene_, factory, modules).makeTree();
}

bool Preview::ready(Component& component) {
  try {
    component.ensureReady();
    return true;
  } catch (const DependencyFailed&) {  // told where it happened
    return false;
  }
}

}  // namespace stroma
