#pragma once

namespace carillon::render {

/// Depth from the light. The slab that a relief is cut into casts no shadow here: within it, the
/// relief itself does.
inline constexpr const char* scene_shadow_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light_from_mesh;
uniform mat4 face_from_mesh;
out vec3 face_position;
void main() {
  face_position = (face_from_mesh * vec4(position, 1.0)).xyz;
  gl_Position = light_from_mesh * vec4(position, 1.0);
}
)";
inline constexpr const char* scene_shadow_fragment = R"(#version 330 core
in vec3 face_position;
uniform vec3 slab;  // width, height and depth; a depth of 0: none
uniform float face_tolerance;
uniform float let_through;  // fraction of the key's light
void main() {
  // As much as this of each four neighbours has no shadow.
  ivec2 place = ivec2(gl_FragCoord.xy) & 1;
  if ((0.5 + float(place.x == place.y ? place.x : 2 + place.x)) < 4.0 * let_through) discard;
  vec2 uv = face_position.xy;
  if (slab.z > 0.0 && face_position.z > -slab.z && all(greaterThan(uv, vec2(-face_tolerance))) &&
      all(lessThan(uv, slab.xy + face_tolerance))) {
    discard;
  }
}
)";

/// One triangle over the whole picture: a backdrop of paper, brighter towards its top.
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

/// Heights of the uppermost bodies: the highest, and minus the lowest, which most bodies have as
/// far below their middle as the highest is above it.
inline constexpr const char* columns_fragment = R"(#version 330 core
in vec3 world_position;
out vec2 heights;
uniform float middle_height;
void main() { heights = vec2(world_position.z, world_position.z - 2.0 * middle_height); }
)";

/// A body's triangles. Places of a textured face are (u, v, height above the face) [m].
inline constexpr const char* scene_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
uniform mat4 clip_from_world;
uniform mat4 world_from_mesh;
uniform mat4 face_from_world;
uniform mat3 world_from_normal;
out vec3 world_position;
out vec3 world_normal;
out vec3 face_position;
out vec3 own_colour;
out vec3 mesh_position;
void main() {
  own_colour = colour;
  mesh_position = position;
  vec4 world = world_from_mesh * vec4(position, 1.0);
  world_position = world.xyz;
  world_normal = world_from_normal * normal;
  face_position = (face_from_world * world).xyz;
  gl_Position = clip_from_world * world;
}
)";

/// After shading, light and grain: what bodies and reliefs have in common.
inline constexpr const char* scene_common = R"(
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 depth_and_body;
uniform vec3 eye;
uniform vec3 forward;
uniform vec3 reflectance;
uniform vec3 deep_reflectance;
uniform float body_number;
uniform vec3 fade_middle;
uniform float fade_distance;  // 0: does not fade

uniform sampler2D slopes;
uniform vec2 map_size;      // [m]
uniform float texel;        // distance of the texture's samples [m]
uniform float pixel_angle;  // of a sample

// Normal of the map at a place, in the face's axes; blurred where a pixel sees many texels.
vec3 map_normal(vec2 uv, float seen_size) {
  vec2 slope = textureLod(slopes, uv / map_size, log2(max(seen_size / texel, 1.0))).rg;
  return normalize(vec3(-slope, 1.0));
}

void put(vec3 position, vec3 n, vec3 reflected, float rough, float lit, float open,
         vec3 through) {
  vec3 v = normalize(eye - position);
  vec3 seen = toned(shade(n, v, reflected, rough, lit, open, through));
  float there = 1.0;
  if (fade_distance > 0.0) {
    float away = length((position - fade_middle).xy) / fade_distance;
    there = 1.0 - smoothstep(0.35, 1.0, away);
  }
  color = vec4(seen, there);
  depth_and_body = vec4(dot(position - eye, forward), body_number, 0.0, 1.0);
}
)";

/// After scene_common: a body's triangles; with CLEAR defined, after glass_code, of clear bodies.
inline constexpr const char* scene_fragment = R"(
in vec3 world_position;
in vec3 world_normal;
in vec3 face_position;
in vec3 own_colour;
in vec3 mesh_position;
uniform int detail;          // 0: none, 1: normal map, 2: relief
uniform mat3 world_from_face;
uniform vec2 face_size;
uniform float face_tolerance;
uniform float deepest;
uniform sampler2D heights;

void main() {
  vec3 v = normalize(eye - world_position);
  vec3 n = normalize(world_normal);
  if (!gl_FrontFacing) n = -n;
  vec3 geometric = n;
  if (detail > 0) {
    vec2 uv = face_position.xy;
    bool inside = all(greaterThan(uv, vec2(-face_tolerance))) &&
                  all(lessThan(uv, face_size + face_tolerance));
    bool upward = dot(n, world_from_face[2]) > 0.999;
    if (inside && detail == 2 && face_position.z > -deepest - face_tolerance) {
      // The face itself is drawn by its relief; a side stands as high as the relief there.
      if (upward && face_position.z > -face_tolerance) discard;
      if (face_position.z > texture(heights, uv / map_size).r) discard;
    }
    if (inside && detail == 1 && upward && abs(face_position.z) < face_tolerance) {
      float slant = max(dot(n, v), 0.05);
      n = world_from_face * map_normal(uv, length(eye - world_position) * pixel_angle / slant);
    }
  }
  float rough = roughness;
  vec3 own = grained(reflectance * own_colour, mesh_position, rough);
  vec3 through = vec3(0.0);
#ifdef CLEAR
  if (transmission > 0.0) through = seen_through(world_position, n, v, own);
#endif
  put(world_position, n, own, rough, lit_by_key(world_position, geometric),
      open_to_all(world_position, geometric), through);
}
)";

/// The slab that a relief is cut into: back faces of a box between the face and its deepest point.
inline constexpr const char* relief_vertex = R"(#version 330 core
uniform mat4 clip_from_world;
uniform mat4 world_from_box;
uniform vec2 face_size;
uniform float deepest;
out vec3 far_place;
const int corners[36] = int[36](0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5);
void main() {
  int corner = corners[gl_VertexID];
  far_place = vec3((corner & 1) != 0 ? face_size.x : 0.0, (corner & 2) != 0 ? face_size.y : 0.0,
                   (corner & 4) != 0 ? 0.0 : -deepest);
  gl_Position = clip_from_world * (world_from_box * vec4(far_place, 1.0));
}
)";

/// After scene_common; with CUT_OUT defined for faces that do not fill the map's rectangle. Rays
/// march through the slab in steps of half a texel, or of a pixel where that is longer, and halve
/// the last one.
inline constexpr const char* relief_fragment = R"(
in vec3 far_place;
uniform mat4 clip_from_world;
uniform mat4 world_from_box;
uniform mat3 world_from_face;
uniform vec3 eye_place;    // in the face's coordinates
uniform vec3 light_place;  // direction, too
uniform vec2 face_size;
uniform float deepest;
uniform sampler2D heights;

uniform int goes_on;       // the face goes on beyond the map's rectangle
uniform vec2 margin;
uniform sampler2D footprint;

bool on_face(vec2 uv) {
  return textureLod(footprint, (uv + margin) / (face_size + 2.0 * margin), 0.0).r > 0.5;
}

float height(vec2 uv) {
#ifdef CUT_OUT
  if (!on_face(uv)) return -2.0 * deepest;
#endif
  return textureLod(heights, uv / map_size, 0.0).r;
}

// Part of the key light that no other part of the relief keeps from a place in it: by how far the
// ray to the lamp's middle passes over what is highest on its way, against the lamp's width there.
float lit_in_relief(vec3 place, vec3 n, float seen_size) {
  vec3 l = light_place;
  if (l.z <= 0.0) return 0.0;
  float way = -place.z / l.z;
  float level = length(l.xy) * way;
  int count = int(clamp(ceil(level / max(texel, seen_size)), 0.0, 256.0));
  // Off the surface by what marching may have missed it by.
  vec3 start = place + n * (0.02 * texel);
  float lit = 1.0;
  for (int i = 1; i <= count; ++i) {
    float gone = way * (float(i) - 0.5) / float(count);
    vec3 p = start + l * gone;
    if (any(lessThan(p.xy, vec2(0.0))) || any(greaterThan(p.xy, face_size))) break;
    float width = max(lamp * gone, 1e-3 * texel);
    lit = min(lit, 0.5 + 0.5 * (p.z - height(p.xy)) / width);
    if (lit <= 0.0) return 0.0;
  }
  return lit;
}

void main() {
  vec3 d = far_place - eye_place;
  // Where the ray enters the slab: at its upper side, at an edge, or at the eye.
  vec3 low = vec3(0.0, 0.0, -deepest), high = vec3(face_size, 0.0);
  float first = 0.0;
  bool from_above = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) continue;
    float enter = ((d[axis] > 0.0 ? low[axis] : high[axis]) - eye_place[axis]) / d[axis];
    if (enter > first) {
      first = enter;
      from_above = axis == 2 && d.z < 0.0;
    }
  }
  if (first >= 1.0) discard;
  vec3 begin = eye_place + first * d;
  if (from_above) begin.z = 0.0;
  vec3 way = far_place - begin;

  vec3 place = begin;
  vec3 wall = vec3(0.0);  // its normal, where the ray ends at one
  if (height(begin.xy) >= begin.z) {
    // At an edge or before the eye: inside the body, whose side is drawn elsewhere.
    if (!from_above) discard;
  } else {
    float seen = length(begin - eye_place) * pixel_angle;
    int count = int(clamp(ceil(length(way.xy) / max(texel, seen)), 8.0, 1024.0));
    float before = 0.0, after = -1.0;
    for (int i = 1; i <= count; ++i) {
      float s = float(i) / float(count);
      vec3 p = begin + s * way;
      if (height(p.xy) >= p.z) {
        after = s;
        break;
      }
      before = s;
    }
    if (after < 0.0) {
      // Out of the rectangle, into what there is beyond it.
      vec2 low_edge = far_place.xy, high_edge = face_size - far_place.xy;
      float nearest = min(min(low_edge.x, low_edge.y), min(high_edge.x, high_edge.y));
      if (low_edge.x == nearest) wall.x = 1.0;
      else if (high_edge.x == nearest) wall.x = -1.0;
      else if (low_edge.y == nearest) wall.y = 1.0;
      else wall.y = -1.0;
      if (goes_on == 0 || far_place.z > -1e-4 * deepest ||
          !on_face(far_place.xy - 0.7 * wall.xy * margin)) {
        discard;
      }
      after = 1.0;
    } else {
      for (int i = 0; i < 10; ++i) {
        float middle = 0.5 * (before + after);
        vec3 p = begin + middle * way;
        if (height(p.xy) >= p.z) after = middle;
        else before = middle;
      }
      // From beside the face to below it: through its side, which is drawn elsewhere.
#ifdef CUT_OUT
      if (!on_face((begin + before * way).xy)) discard;
#endif
    }
    place = begin + after * way;
  }

  float seen_size = length(place - eye_place) * pixel_angle;
  float slant = max(normalize(-d).z, 0.05);
  vec3 n = wall == vec3(0.0) ? map_normal(place.xy, seen_size / slant) : wall;
  vec3 position = (world_from_box * vec4(place, 1.0)).xyz;
  float lit = lit_in_relief(place, n, seen_size);
  if (lit > 0.0) lit *= lit_by_key(position, world_from_face * n);
  float cut = smoothstep(0.25, 0.75, -place.z / deepest);
  // The bodies' columns know the face, not what is cut into it.
  vec3 level = (world_from_box * vec4(place.xy, 0.0, 1.0)).xyz;
  put(position, world_from_face * n, mix(reflectance, deep_reflectance, cut), roughness, lit,
      open_to_all(level, world_from_face[2]), vec3(0.0));
  vec4 clip = clip_from_world * vec4(position, 1.0);
  gl_FragDepth = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
}
)";

}  // namespace carillon::render
