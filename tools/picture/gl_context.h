// SPDX-License-Identifier: LGPL-2.1-or-later
// OpenGL without a display: an EGL context that belongs to no window. Debian's VTK knows windows of X11 alone, but draws into
// any context that is current (vtkGenericOpenGLRenderWindow).
#pragma once
#include <string>

namespace stroma::picture {

/// A context of OpenGL 3.2 or better, current from its making to its end. Tried in this order: Mesa's surfaceless platform,
/// which draws by software where there is no graphics card; the devices of other drivers; the default display.
class GlContext {
 public:
  /// Throws std::runtime_error with what was tried and the packages that help.
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  /// Who draws: "llvmpipe (LLVM 15.0.6, 256 bits)".
  const std::string& renderer() const { return renderer_; }

 private:
  bool begin(void* display);

  void *display_ = nullptr, *context_ = nullptr;
  std::string renderer_;
};

}  // namespace stroma::picture
