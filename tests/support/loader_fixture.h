// SPDX-License-Identifier: LGPL-2.1-or-later
// A folder of its own for the files of each test, and what a scene says when it does not load.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "framework/mesh/mesh_loader.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

class LoaderTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("loaders" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static std::string sceneText(const std::string& type, const std::string& file, const std::string& attributes = {}) {
    return "<Node name=\"root\"><" + type + " name=\"loader\" filename=\"" + file + "\" " + attributes + "/></Node>";
  }
  static const Mesh& mesh(const Scene& scene) {
    return dynamic_cast<MeshLoader&>(*findComponent(*scene.root, "/loader")).mesh();
  }
  static std::string errors(const std::string& text) {
    try {
      sceneFromText(text);
    } catch (const SceneError& error) {
      return error.diagnostics().text();
    }
    return {};
  }
  static void expectIn(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in:\n" << text;
  }
  std::filesystem::path folder_;
};

}  // namespace stroma::test
