// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tests/support/loader_fixture.h"

namespace stroma::test {

class VtkTest : public LoaderTest {
 protected:
  static Mesh load(const std::string& type, const std::string& file, const std::string& attributes = {}) {
    const Scene scene = sceneFromText(sceneText(type, file, attributes));
    return mesh(scene);
  }
  static std::string bytesOf(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
};

}  // namespace stroma::test
