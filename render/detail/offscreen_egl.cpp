#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <array>
#include <string>

#include "core/error.hpp"
#include "render/detail/offscreen.hpp"
#include "render/frame.hpp"

namespace carillon::render {

namespace {

/// Throws what EGL's last call came to.
[[noreturn]] void fail_egl(const std::string& what) {
  throw core::Error(fmt::format("EGL {} (error 0x{:04x})", what, eglGetError()),
                    "are Mesa's EGL and its software renderer installed (Debian: libegl1 and "
                    "libgl1-mesa-dri)?");
}

/// Mesa's display without a window system. A process has one, whose threads share it: it ends with
/// the process.
EGLDisplay surfaceless_display() {
  static const EGLDisplay display = [] {
    const char* known = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (known == nullptr ||
        std::string(known).find("EGL_MESA_platform_surfaceless") == std::string::npos) {
      fail_egl("has no platform without surfaces");
    }
    const EGLDisplay found =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (found == EGL_NO_DISPLAY || eglInitialize(found, nullptr, nullptr) != EGL_TRUE) {
      fail_egl("cannot open a display without surfaces");
    }
    return found;
  }();
  return display;
}

}  // namespace

struct OffscreenContext::Platform {
  EGLDisplay display = surfaceless_display();
  EGLContext context = EGL_NO_CONTEXT;

  ~Platform() {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglReleaseThread();
  }
};

OffscreenContext::OffscreenContext() : platform_(std::make_unique<Platform>()) {
  const EGLDisplay display = platform_->display;
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) fail_egl("knows no OpenGL");
  const std::array<EGLint, 5> wanted = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                        EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint found = 0;
  if (eglChooseConfig(display, wanted.data(), &config, 1, &found) != EGL_TRUE || found == 0) {
    fail_egl("has no configuration for OpenGL");
  }
  const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                            3,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            3,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
  platform_->context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
  if (platform_->context == EGL_NO_CONTEXT) fail_egl("cannot make an OpenGL 3.3 context");
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, platform_->context) != EGL_TRUE) {
    fail_egl("cannot draw without a surface");
  }
}

OffscreenContext::~OffscreenContext() = default;

std::string_view offscreen() {
  return "egl";
}

}  // namespace carillon::render
