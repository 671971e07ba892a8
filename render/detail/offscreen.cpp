#include "render/detail/offscreen.hpp"

#include <fmt/format.h>

#include <array>

#include "core/error.hpp"

namespace carillon::render {

namespace {

Shader compile(GLenum kind, const std::string& source) {
  Shader shader(glCreateShader(kind));
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint good = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &good);
  if (good != GL_TRUE) {
    std::array<char, 2048> log{};
    glGetShaderInfoLog(shader.get(), log.size(), nullptr, log.data());
    throw core::Error(fmt::format("shader does not compile: {}", log.data()));
  }
  return shader;
}

}  // namespace

OffscreenContext& offscreen_context() {
  thread_local OffscreenContext context;
  return context;
}

Program make_program(const std::string& vertex_source, const std::string& fragment_source) {
  const Shader vertex = compile(GL_VERTEX_SHADER, vertex_source);
  const Shader fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
  Program program(glCreateProgram());
  glAttachShader(program.get(), vertex.get());
  glAttachShader(program.get(), fragment.get());
  glLinkProgram(program.get());
  GLint good = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &good);
  if (good != GL_TRUE) {
    std::array<char, 2048> log{};
    glGetProgramInfoLog(program.get(), log.size(), nullptr, log.data());
    throw core::Error(fmt::format("shaders do not link: {}", log.data()));
  }
  return program;
}

void check_gl(const char* step) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  throw core::Error(fmt::format("OpenGL error 0x{:04x} while {}", error, step));
}

}  // namespace carillon::render
