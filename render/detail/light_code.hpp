#pragma once

namespace carillon::render {

/// After shading: how much of the key's light and of the light from all around reaches a place.
/// The samples of a pixel share the points of one sunflower spiral, each takes every so many of
/// them: no noise from pixel to pixel, and the same bytes each time.
///
/// The key's shadow is filtered over the penumbra of the lamp's disc: the mean distance of what is
/// in the way, by the lamp's angle (percentage-closer soft shadows, Fernando 2005), on the plane of
/// the surface. The light from all around is kept away by the columns of the uppermost bodies
/// between their highest and lowest heights: what these bands cover of the cosine-weighted
/// hemisphere, in some directions and at two distances in each.
inline constexpr const char* light_code = R"(
uniform mat4 light_from_world;
uniform sampler2DShadow shadow_map;
uniform sampler2D shadow_depths;
uniform float lamp;            // tangent of the lamp's angular radius
uniform float shadow_extent;   // of the map [m]
uniform float shadow_search;   // part of the map in which there may be something in the way
uniform float shadow_texel;    // part of the map
uniform int samples;           // per pixel and direction
uniform int shadow_taps;       // per sample
uniform sampler2D columns;     // highest height of bodies, and minus the lowest [m]
uniform vec3 columns_place;    // lower corner's x and y, and the side [m]
uniform float cover_distance;  // up to which they count [m]
uniform int cover_directions;  // per sample
uniform int cover_rings;       // distances in each

const float golden_angle = 2.39996323;

int sample_number() {
  ivec2 place = ivec2(gl_FragCoord.xy) % samples;
  return place.y * samples + place.x;
}

float lit_by_key(vec3 position, vec3 normal) {
  vec3 slant = mat3(light_from_world) * normal;
  if (slant.z >= 0.0) return 0.0;
  vec3 raised = position + 0.75 * shadow_texel * shadow_extent * normal;
  vec3 there = (light_from_world * vec4(raised, 1.0)).xyz * 0.5 + 0.5;
  if (any(lessThan(there.xy, vec2(0.0))) || any(greaterThan(there.xy, vec2(1.0)))) return 1.0;
  there.z = clamp(there.z, 0.0, 1.0);
  vec2 plane = clamp(-slant.xy / slant.z, -6.0, 6.0);
  int first = sample_number(), step = samples * samples;
  int all = shadow_taps * step;
  float angle = golden_angle * float(first), turn = golden_angle * float(step);
  vec2 way = vec2(cos(angle), sin(angle));
  mat2 turned = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));

  float blockers = 0.0, depth = 0.0;
  vec2 w = way;
  for (int i = 0; i < shadow_taps; ++i) {
    // Densest in the middle, where what is near keeps light away.
    float part = (float(first + i * step) + 0.5) / float(all);
    vec2 off = shadow_search * part * w;
    float seen = textureLod(shadow_depths, there.xy + off, 0.0).r;
    float before = there.z + dot(plane, off) - seen - shadow_texel;
    if (before > 0.0) {
      blockers += 1.0;
      depth += before;
    }
    w = turned * w;
  }
  float radius = 1.25 * shadow_texel;
  if (blockers > 0.0) radius = max(radius, lamp * depth / blockers);
  float sum = 0.0;
  for (int i = 0; i < shadow_taps; ++i) {
    vec2 off = radius * sqrt((float(first + i * step) + 0.5) / float(all)) * way;
    sum += texture(shadow_map, vec3(there.xy + off, there.z + dot(plane, off) - shadow_texel));
    way = turned * way;
  }
  return sum / float(shadow_taps);
}

float open_to_all(vec3 p, vec3 n) {
  vec2 uv = (p.xy - columns_place.xy) / columns_place.z;
  float margin = cover_distance / columns_place.z;
  if (any(lessThan(uv, vec2(-margin))) || any(greaterThan(uv, vec2(1.0 + margin)))) return 1.0;
  int first = sample_number();
  float part = (float(first) + 0.5) / float(samples * samples);
  float blocked = 0.0;
  for (int i = 0; i < cover_directions; ++i) {
    float angle = golden_angle * float(first + 1) + 6.2831853 * float(i) / float(cover_directions);
    vec2 way = vec2(cos(angle), sin(angle));
    float along = dot(n.xy, way);
    // The tangent plane's elevation in this direction.
    float edge = (n.z > 0.0 ? -along : along) * inversesqrt(along * along + n.z * n.z + 1e-9);
    float most = 0.0;
    for (int k = 0; k < cover_rings; ++k) {
      float far = (float(k) + part) / float(cover_rings);
      float r = cover_distance * (0.04 + 0.96 * far * far);
      vec2 heights = textureLod(columns, uv + way * (r / columns_place.z), 0.0).rg;
      vec2 rise = clamp(vec2(heights.x - p.z, -heights.y - p.z), -100.0 * r, 100.0 * r);
      vec2 sines = rise * inversesqrt(rise * rise + r * r);  // of the top's and bottom's elevation
      if (n.z > 0.0) sines.y = max(sines.y, edge);
      else sines.x = min(sines.x, edge);
      float middle = 0.5 * (sines.x + sines.y);
      float weight = along * sqrt(max(1.0 - middle * middle, 0.0)) + n.z * middle;
      most = max(most, max(weight, 0.0) * (sines.x - sines.y));
    }
    blocked += most;
  }
  return clamp(1.0 - 2.0 * blocked / float(cover_directions), 0.0, 1.0);
}
)";

}  // namespace carillon::render
