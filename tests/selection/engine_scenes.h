// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes of one engine, named e, and what it has made.
#pragma once
#include "tests/support/scene_fixture.h"

namespace stroma::test {

template <class T>
T made(const Scene& scene, const std::string& attribute) {
  return *std::get<T*>(findComponent(*scene.root, "/e")->data().find(attribute)->pointer());
}
inline Scene engine(const std::string& text, const std::string& before = "") {
  return sceneFromText("<Node name='root'>" + before + text + "</Node>");
}

}  // namespace stroma::test
