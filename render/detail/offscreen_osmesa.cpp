#include "render/detail/offscreen.hpp"

#include <GL/osmesa.h>

#include <array>

#include "core/error.hpp"
#include "render/frame.hpp"

namespace carillon::render {

struct OffscreenContext::Platform {
  OSMesaContext context = nullptr;
  std::array<unsigned char, 4> pixel{};

  ~Platform() { OSMesaDestroyContext(context); }
};

OffscreenContext::OffscreenContext() : platform_(std::make_unique<Platform>()) {
  const std::array<int, 12> attributes = {OSMESA_FORMAT,
                                          OSMESA_RGBA,
                                          OSMESA_DEPTH_BITS,
                                          0,
                                          OSMESA_PROFILE,
                                          OSMESA_CORE_PROFILE,
                                          OSMESA_CONTEXT_MAJOR_VERSION,
                                          3,
                                          OSMESA_CONTEXT_MINOR_VERSION,
                                          3,
                                          0,
                                          0};
  platform_->context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
  if (platform_->context == nullptr) {
    throw core::Error("OSMesa cannot make an OpenGL 3.3 context",
                      "is the package libosmesa6 with llvmpipe installed?");
  }
  if (OSMesaMakeCurrent(platform_->context, platform_->pixel.data(), GL_UNSIGNED_BYTE, 1, 1) !=
      GL_TRUE) {
    throw core::Error("OSMesa cannot draw into memory");
  }
}

OffscreenContext::~OffscreenContext() = default;

std::string_view offscreen() {
  return "osmesa";
}

}  // namespace carillon::render
