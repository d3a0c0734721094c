// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <array>
#include <stdexcept>

// VTK asks GLEW for OpenGL's functions. Debian's GLEW finds them, then looks for an X display besides, and reports that there
// is none; VTK takes that for a failure. This is found in GLEW's place, and takes it for what it is.
extern "C" __attribute__((visibility("default"))) unsigned int glewInit() {
  constexpr unsigned int ok = 0, no_glx_display = 4;
  const auto of_glew = reinterpret_cast<unsigned int (*)()>(dlsym(RTLD_NEXT, "glewInit"));
  if (!of_glew) return 1;  // GLEW's "no version"
  const unsigned int result = of_glew();
  return result == no_glx_display ? ok : result;
}

namespace stroma::picture {
namespace {

constexpr EGLint version[] = {
    EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 2, EGL_CONTEXT_OPENGL_PROFILE_MASK,
    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};

template <class Function>
Function function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

EGLDisplay displayOf(EGLenum platform, void* native) {
  const auto get = function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  return get ? get(platform, native, nullptr) : EGL_NO_DISPLAY;
}

}  // namespace

bool GlContext::begin(void* display) {
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return false;
  if (eglBindAPI(EGL_OPENGL_API)) {
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
    if (context != EGL_NO_CONTEXT && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
      display_ = display, context_ = context;
      using GetString = const unsigned char* (*)(unsigned int);
      constexpr unsigned int gl_renderer = 0x1F01;
      if (const auto get = function<GetString>("glGetString"))
        if (const unsigned char* name = get(gl_renderer)) renderer_ = reinterpret_cast<const char*>(name);
      return true;
    }
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
  }
  eglTerminate(display);
  return false;
}

GlContext::GlContext() {
  if (begin(displayOf(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY))) return;
  std::array<EGLDeviceEXT, 8> devices;
  EGLint count = 0;
  const auto query = function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (query && query(EGLint(devices.size()), devices.data(), &count))
    for (EGLint i = 0; i < count; ++i)
      if (begin(displayOf(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)]))) return;
  if (begin(eglGetDisplay(EGL_DEFAULT_DISPLAY))) return;
  throw std::runtime_error(
      "no OpenGL 3.2 without a display: EGL has neither a software renderer nor a graphics card here (expected the "
      "packages libegl-mesa0 and libgl1-mesa-dri: apt-get install libegl-mesa0 libgl1-mesa-dri)");
}

GlContext::~GlContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

}  // namespace stroma::picture
