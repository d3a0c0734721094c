// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/scene_program.h"

namespace stroma {
namespace {

std::unique_ptr<SceneProgram>& player() {
  static std::unique_ptr<SceneProgram> program;
  return program;
}

}  // namespace

bool isSceneProgram(std::string_view file) { return file.ends_with(".py") || file.ends_with(".pyscn"); }

void setSceneProgram(std::unique_ptr<SceneProgram> program) { player() = std::move(program); }

SceneProgram& sceneProgram() {
  if (!player()) throw ProgramError("a scene in Python is run by the command: name it there, as stroma run scene.py");
  return *player();
}

}  // namespace stroma
