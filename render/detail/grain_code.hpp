#pragma once

namespace carillon::render {

/// After shading: solid textures, by value noise on the lattice of whole numbers, whose values are
/// Jarzynski and Olano's hash pcg3d (2020). A unit of length is 30 mm, of small bodies less.
/// Changes the reflectance, and how rough it is, of a body whose `grain_kind` says so
/// (looks::Grain).
inline constexpr const char* grain_code = R"(
uniform int grain_kind;
uniform float grain_contrast;
uniform float grain_scale;  // units to the radius of the body's ball
uniform mat3 grain_axes;    // rows: along the grain, and two across
uniform vec3 grain_offset;
uniform int grain_layers;    // of patterns that add some up: unrolled, they take llvmpipe seconds
uniform float plank_width;  // of a floor of wood; 0: one piece

float lattice(ivec3 cell) {
  uvec3 v = uvec3(cell) * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  return float(v.x >> 8u) / 16777216.0;
}

// From 0 to 1, one hump per unit of length.
float noise(vec3 p) {
  ivec3 cell = ivec3(floor(p));
  vec3 t = p - floor(p);
  t = t * t * (3.0 - 2.0 * t);
  vec4 low, high;
  for (int i = 0; i < 4; ++i) {
    ivec3 corner = cell + ivec3(i & 1, i >> 1, 0);
    low[i] = lattice(corner);
    high[i] = lattice(corner + ivec3(0, 0, 1));
  }
  vec4 side = mix(low, high, t.z);
  return mix(mix(side.x, side.y, t.x), mix(side.z, side.w, t.x), t.y);
}

// What is left of a pattern with so many humps a unit where a sample is so many units wide.
float shown(float humps, float sample_width) { return 1.0 - smoothstep(0.35, 0.9, humps * sample_width); }

// Factor of a floor's boards, and p within one: each is cut elsewhere, and a little lighter or
// darker; between them are joints.
float planks(inout vec3 p) {
  float across = p.y / plank_width;
  float row = floor(across);
  float along = p.x / (9.0 * plank_width) + 0.37 * row;
  ivec3 board = ivec3(int(row), int(floor(along)), 7);
  float chance = lattice(board), other = lattice(board + ivec3(0, 0, 1));
  vec2 joint = vec2(0.5 - abs(across - row - 0.5), 9.0 * (0.5 - abs(fract(along) - 0.5))) * plank_width;
  float wide = 0.5 * fwidth(p.y) + 0.5 * fwidth(p.x);
  float gap = max(1.0 - smoothstep(0.02, 0.045 + wide, joint.x), 1.0 - smoothstep(0.02, 0.045 + wide, joint.y));
  p = vec3(p.x + 31.0 * chance, (across - row - 0.2 - 0.6 * other) * plank_width, 1.0 + 2.0 * chance);
  return (0.86 + 0.24 * other) * (1.0 - 0.6 * gap * (0.05 / (0.05 + wide)));
}

// Growth rings about the x axis: latewood darkens towards each ring's outside and ends sharply;
// where rings are narrower than what a sample sees, they are their mean. Rays are light flecks that
// stand on the rings; fibres are streaks along the axis, and pores short dark ones.
float wood(vec3 p) {
  const float rings = 9.0, mean = 0.30;
  float wide = max(length(fwidth(p.yz)), 0.5 * fwidth(p.x));
  vec2 wander = vec2(noise(vec3(0.5 * p.x, 1.3 * p.yz)), noise(vec3(0.5 * p.x + 50.0, 1.3 * p.zy)));
  vec2 place = p.yz + 0.30 * (wander - 0.5);
  float ring = rings * length(place);
  float width = fwidth(ring);
  ring += 0.7 * noise(vec3(0.35 * ring, 0.3 * p.x, 0.0));
  float part = fract(ring);
  float late = smoothstep(0.2, 0.86, part);
  late = late * late * (1.0 - smoothstep(0.9, 0.9 + max(0.08, width), part));
  late = mix(late, mean, smoothstep(0.35, 0.8, width));
  float fibre = (noise(vec3(1.2, 26.0, 26.0) * p) - 0.5) * shown(26.0, wide) +
                0.6 * (noise(vec3(3.0, 70.0, 70.0) * p) - 0.5) * shown(70.0, wide);
  float angle = atan(place.y, place.x);
  float ray = smoothstep(0.70, 0.86, noise(vec3(9.0 * p.x, 34.0 * angle, 0.5 * ring))) *
              shown(30.0, wide);
  float pore = smoothstep(0.74, 0.86, noise(vec3(3.5, 48.0, 48.0) * p + 9.0)) * (1.0 - late) *
               shown(48.0, wide);
  return 1.0 + grain_contrast * (0.32 - 1.05 * late + 0.55 * fibre + 0.16 * ray - 0.45 * pore);
}

// Two lattices that lie askew to each other and to the body show neither's squares.
float grains(vec3 p) {
  const mat3 askew = mat3(0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6);
  vec3 q = askew * p;
  return 0.5 * (noise(q) + noise(askew * q * 1.13 + 5.0));
}

float speckles(vec3 p) {
  const vec3 sizes = vec3(15.0, 19.0, 43.0), shifts = vec3(0.0, 17.0, 0.0);
  vec3 layers = vec3(0.0);
  for (int i = 0; i < grain_layers; ++i) layers[i] = grains(sizes[i] * p + shifts[i]);
  float dark = smoothstep(0.57, 0.62, layers.x), light = smoothstep(0.56, 0.61, layers.y);
  float fine = layers.z - 0.5;
  return 1.0 + grain_contrast * (0.6 * light - 0.8 * dark + 0.5 * fine);
}

float veins(vec3 p) {
  float turbulent = 0.0, size = 1.0;
  for (int octave = 0; octave < grain_layers; ++octave) {
    turbulent += abs(2.0 * noise(p * 2.0 / size + 7.0 * float(octave)) - 1.0) * size;
    size *= 0.5;
  }
  float band = abs(sin(2.2 * p.y + 1.3 * p.x + 3.4 * turbulent));
  return 1.0 - grain_contrast * (0.75 * pow(1.0 - band, 3.0) + 0.15 * (turbulent - 0.6));
}

// Fine lines of a brush along the longest axis, and broader ones where it pressed more.
float brushed(vec3 p) {
  float wide = length(fwidth(p.yz));
  float fine = (noise(vec3(0.8, 80.0, 80.0) * p) - 0.5) * shown(80.0, wide);
  return 2.0 * grain_contrast * (fine + 0.5 * (noise(vec3(0.5, 14.0, 14.0) * p) - 0.5));
}

vec3 grained(vec3 reflected, vec3 place, inout float rough) {
  if (grain_kind == 0) return reflected;
  vec3 p = grain_scale * (grain_axes * place) + grain_offset;
  if (grain_kind == 4) {
    float line = brushed(p);
    rough = clamp(rough * (1.0 + 0.9 * line), 0.05, 1.0);
    return reflected * (1.0 - 0.12 * line);
  }
  float board = plank_width > 0.0 ? planks(p) : 1.0;
  float factor = board * (grain_kind == 1 ? wood(p) : grain_kind == 2 ? speckles(p) : veins(p));
  // Dark parts of wood are redder, as their colour is the deeper one, and duller.
  vec3 deeper = grain_kind == 1 ? vec3(0.8, 1.0, 1.22) : vec3(1.0);
  if (grain_kind == 1) rough = clamp(rough + 0.15 * (1.0 - factor), 0.05, 1.0);
  return clamp(reflected * pow(vec3(max(factor, 0.05)), deeper), 0.0, 1.0);
}
)";

}  // namespace carillon::render
