// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that loaders read, and what a scene says when it does not load.
#pragma once
#include "framework/mesh/mesh_loader.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

class LoaderTest : public FolderTest {
 protected:
  static std::string sceneText(const std::string& type, const std::string& file, const std::string& attributes = {}) {
    return "<Node name=\"root\"><" + type + " name=\"loader\" filename=\"" + file + "\" " + attributes + "/></Node>";
  }
  static const Mesh& mesh(const Scene& scene) {
    return dynamic_cast<MeshLoader&>(*findComponent(*scene.root, "/loader")).mesh();
  }
  static std::string errors(const std::string& text) {
    return problemsIn([&] { sceneFromText(text); });
  }
};

}  // namespace stroma::test
