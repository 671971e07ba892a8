#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include <memory>
#include <string>

#include "core/handle.hpp"

namespace carillon::render {

inline void delete_buffer(GLuint* name) {
  glDeleteBuffers(1, name);
}
inline void delete_vertex_array(GLuint* name) {
  glDeleteVertexArrays(1, name);
}
inline void delete_framebuffer(GLuint* name) {
  glDeleteFramebuffers(1, name);
}
inline void delete_texture(GLuint* name) {
  glDeleteTextures(1, name);
}
inline void delete_sampler(GLuint* name) {
  glDeleteSamplers(1, name);
}
inline void delete_shader(GLuint* name) {
  glDeleteShader(*name);
}
inline void delete_program(GLuint* name) {
  glDeleteProgram(*name);
}

using Buffer = core::Handle<GLuint, delete_buffer>;
using VertexArray = core::Handle<GLuint, delete_vertex_array>;
using Framebuffer = core::Handle<GLuint, delete_framebuffer>;
using Texture = core::Handle<GLuint, delete_texture>;
using Sampler = core::Handle<GLuint, delete_sampler>;
using Shader = core::Handle<GLuint, delete_shader>;
using Program = core::Handle<GLuint, delete_program>;

/// OpenGL 3.3 core profile in memory (Mesa's llvmpipe), by OSMesa or by EGL without a surface: the
/// build has one of offscreen_osmesa.cpp and offscreen_egl.cpp. Draws in the thread that made it,
/// without threads of its own: ranks share the cores, not pictures. Everything is drawn into
/// framebuffer objects; the context itself has a surface of one pixel or none.
class OffscreenContext {
 public:
  /// @throws core::Error  no context can be made
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  struct Platform;
  std::unique_ptr<Platform> platform_;
};

/// The calling thread's context, made at the first call and kept: what is drawn with belongs to the
/// thread.
/// @throws core::Error  no context can be made
OffscreenContext& offscreen_context();

/// @throws core::Error  with the compiler's or linker's message
Program make_program(const std::string& vertex_source, const std::string& fragment_source);

/// @throws core::Error  OpenGL reported an error since the last call; names the step
void check_gl(const char* step);

}  // namespace carillon::render
