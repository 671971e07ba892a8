#pragma once

namespace carillon::render {

/// Depth of the body seen from the key light.
inline constexpr const char* shadow_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light_from_body;
void main() { gl_Position = light_from_body * vec4(position, 1.0); }
)";
inline constexpr const char* shadow_fragment = R"(#version 330 core
void main() {}
)";

/// One triangle over the whole picture.
inline constexpr const char* background_vertex = R"(#version 330 core
out float height;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = corner.y;
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";
inline constexpr const char* background_fragment = R"(#version 330 core
in float height;
out vec4 color;
void main() { color = vec4(vec3(mix(0.52, 0.80, 0.5 + 0.5 * height)), 1.0); }
)";

inline constexpr const char* body_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
uniform mat4 clip_from_body;
out vec3 body_position;
out vec3 body_normal;
out vec3 body_colour;
void main() {
  body_colour = colour;
  body_position = position;
  body_normal = normal;
  gl_Position = clip_from_body * vec4(position, 1.0);
}
)";

/// After shading and grain.
inline constexpr const char* body_fragment = R"(
in vec3 body_position;
in vec3 body_normal;
in vec3 body_colour;
out vec4 color;
uniform mat4 light_from_body;
uniform vec3 eye;
uniform vec3 reflectance;
uniform sampler2DShadow shadow_map;

float lit_by_key(vec3 normal) {
  // A step along the normal keeps a face out of its own shadow.
  vec4 there = light_from_body * vec4(body_position + 0.012 * normal, 1.0);
  vec3 light_position = there.xyz * 0.5 + 0.5;
  float sum = 0.0;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      vec2 offset = vec2(i, j) * (2.5 / 1024.0);
      sum += texture(shadow_map, vec3(light_position.xy + offset, light_position.z - 0.002));
    }
  }
  return sum / 9.0;
}

void main() {
  vec3 v = normalize(eye - body_position);
  vec3 n = normalize(body_normal);
  if (!gl_FrontFacing) n = -n;
  vec3 own = grained(reflectance * body_colour, body_position);
  color = vec4(shade(n, v, own, lit_by_key(n)), 1.0);
}
)";

}  // namespace carillon::render
