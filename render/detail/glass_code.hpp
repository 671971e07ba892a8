#pragma once

namespace carillon::render {

/// Back faces of clear bodies: their outward normal, and the depth along the camera's axis.
inline constexpr const char* back_fragment = R"(#version 330 core
in vec3 world_position;
in vec3 world_normal;
out vec4 normal_and_depth;
uniform vec3 eye;
uniform vec3 forward;
void main() {
  vec3 n = normalize(world_normal);
  if (dot(n, world_position - eye) < 0.0) n = -n;  // an inside-out mesh
  normal_and_depth = vec4(n, dot(world_position - eye, forward));
}
)";

/// After scene_common: what is seen through a clear body with an index of 1.5. A ray is refracted
/// where it enters and where it leaves at the back faces that the camera sees through it (Wyman
/// 2005), and goes on to what is drawn behind; of what is not in the picture it sees the studio.
/// Total reflection at the far side turns it once. The body's colour is what comes through as much
/// of it as its ball is wide.
inline constexpr const char* glass_code = R"(
uniform sampler2D back_faces;
uniform sampler2D behind_color;
uniform sampler2D behind_places;
uniform mat4 clip_from_world;
uniform float body_size;  // [m]
uniform int steps_in_glass, steps_behind;  // towards where a ray meets what it meets

const float glass_index = 1.5;

vec2 on_picture(vec3 place) {
  vec4 clip = clip_from_world * vec4(place, 1.0);
  return clip.w > 0.0 ? 0.5 + 0.5 * clip.xy / clip.w : vec2(-1.0);
}

bool in_picture(vec2 uv) {
  return all(greaterThan(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
}

// The place at a depth on the camera's ray to a place.
vec3 at_depth(vec3 place, float depth) {
  vec3 ray = place - eye;
  return eye + ray * (depth / dot(ray, forward));
}

vec3 seen_through(vec3 p, vec3 n, vec3 v, vec3 tint) {
  vec3 d = refract(-v, n, 1.0 / glass_index);
  vec4 back = textureLod(back_faces, on_picture(p), 0.0);
  if (back.w <= 0.0) back = vec4(-n, dot(p - eye, forward));
  float way = length(at_depth(p, back.w) - p);
  for (int i = 0; i < steps_in_glass; ++i) {
    vec4 there = textureLod(back_faces, on_picture(p + way * d), 0.0);
    if (there.w <= 0.0) break;
    back = there;
    way = clamp(dot(at_depth(p + way * d, back.w) - p, d), 0.0, body_size);
  }
  vec3 q = p + way * d;
  vec3 e = refract(d, -back.xyz, glass_index);
  if (dot(e, e) < 0.5) e = reflect(d, -back.xyz);
  vec3 absorbed = pow(max(tint, vec3(1e-3)), vec3(way / body_size));

  // On to where it meets what is drawn, or away to the backdrop.
  vec2 uv = on_picture(q + 1e4 * body_size * e);
  float s = 0.0;
  for (int i = 0; i < steps_behind; ++i) {
    vec2 near = on_picture(q + s * e);
    if (!in_picture(near)) break;
    float depth = textureLod(behind_places, near, 0.0).r;
    if (isinf(depth)) break;
    uv = near;
    s = max(dot(at_depth(q + s * e, depth) - q, e), 0.0);
  }
  vec3 seen = in_picture(uv) ? textureLod(behind_color, uv, 0.0).rgb
                             : toned(studio(e, 0.1, 1.0, 1.0));
  return absorbed * seen;
}
)";

}  // namespace carillon::render
