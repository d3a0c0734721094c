// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that is a program: a file of Python, which describes a scene and takes part in its steps. Sessions know it by this
// door only; who plays it is in the same process (tools/python/sofa_compat).
#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "framework/simulation/simulation.h"

namespace stroma {

class Session;

/// The program of a scene has failed: a sentence with its place. A step that it came before was not made.
class ProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a pointer does in a picture of the scene. States are those of SOFA: 0 moves, 1 and 2 left pressed and released, 3 and
/// 4 right, 5 wheel, 6 and 7 middle.
struct Mouse {
  long state, x, y, wheel;  ///< [pixels] from the upper left corner; a notch of a wheel is 120
};

class SceneProgram {
 public:
  virtual ~SceneProgram() = default;
  /// Runs the file and returns the scene that it makes, for `session`. Throws SceneError or ProgramError.
  virtual SceneDescription describe(const std::string& file, Session& session) = 0;
  /// The scene that was described is loaded.
  virtual void loaded(Session& session) = 0;
  /// Between two steps, by the thread that steps. Both throw ProgramError.
  virtual void beforeStep(Simulation& simulation) = 0;
  virtual void afterStep(Simulation& simulation) = 0;
  /// A key of a page that shows the run, by its name there: "a", "ArrowUp". By the thread that steps, between steps.
  virtual void key(const std::string& name, bool pressed) = 0;
  /// The pointer of such a page, likewise.
  virtual void mouse(const Mouse&) {}
};

/// Whether a scene file is a program, by its name.
bool isSceneProgram(std::string_view file);
/// Plays programs of all sessions from now on; null: nobody does. Before the first scene is loaded.
void setSceneProgram(std::unique_ptr<SceneProgram> program);
/// Throws ProgramError when nobody does.
SceneProgram& sceneProgram();

}  // namespace stroma
