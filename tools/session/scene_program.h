// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that is a program: a Python file that describes a scene and takes part in its steps. This is the only interface that
// sessions use; the implementation runs in the same process (tools/python/sofa_compat).
#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "framework/simulation/simulation.h"

namespace stroma {

class Session;

/// The program of a scene has failed: a message with its location. The step after it was not made.
class ProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A pointer event in a view of the scene. States are those of SOFA: 0 move, 1 and 2 left button pressed and released, 3 and
/// 4 right button, 5 wheel, 6 and 7 middle button.
struct Mouse {
  long state, x, y, wheel;  ///< [pixels] from the upper left corner; a notch of a wheel is 120
};

class SceneProgram {
 public:
  virtual ~SceneProgram() = default;
  /// Runs the file and returns the scene that it describes, for `session`. Throws SceneError or ProgramError.
  virtual SceneDescription describe(const std::string& file, Session& session) = 0;
  /// Called when the described scene is loaded.
  virtual void loaded(Session& session) = 0;
  /// Called between two steps, by the stepping thread. Both throw ProgramError.
  virtual void beforeStep(Simulation& simulation) = 0;
  virtual void afterStep(Simulation& simulation) = 0;
  /// A key pressed in a page that shows the run, by its name there: "a", "ArrowUp". Called by the stepping thread, between steps.
  virtual void key(const std::string& name, bool pressed) = 0;
  /// A pointer event in such a page, in the same way.
  virtual void mouse(const Mouse&) {}
};

/// Whether a scene file is a program, by its name.
bool isSceneProgram(std::string_view file);
/// Sets the interpreter for all sessions; null: none. Call it before the first scene is loaded.
void setSceneProgram(std::unique_ptr<SceneProgram> program);
/// Throws ProgramError if there is none.
SceneProgram& sceneProgram();

}  // namespace stroma
