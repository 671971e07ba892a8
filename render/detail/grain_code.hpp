#pragma once

namespace carillon::render {

/// After shading: solid textures, by value noise on the lattice of whole numbers, whose values are
/// Jarzynski and Olano's hash pcg3d (2020). Places are in the coordinates of the body's ball.
/// Changes the reflectance of a body whose `grain_kind` says so (looks::Grain).
inline constexpr const char* grain_code = R"(
uniform int grain_kind;
uniform float grain_contrast;
uniform mat3 grain_axes;    // rows: along the grain, and two across
uniform vec3 grain_offset;

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

// Latewood darkens towards each ring's outside and ends sharply; where rings are narrower than what
// a sample sees, it is their mean. Fibres are streaks along the axis.
float wood(vec3 p) {
  const float rings = 9.0, mean = 0.27;
  vec2 wander = vec2(noise(vec3(0.9 * p.x, 1.7 * p.yz)), noise(vec3(0.9 * p.x + 50.0, 1.7 * p.zy)));
  float ring = rings * length(p.yz + 0.22 * (wander - 0.5));
  ring += 0.5 * noise(vec3(ring, 0.3 * p.x, 0.0));
  float part = fract(ring);
  float late = smoothstep(0.25, 0.88, part) * (1.0 - smoothstep(0.9, 1.0, part));
  late = mix(late, mean, smoothstep(0.3, 0.8, fwidth(ring)));
  float fibre = noise(vec3(2.0, 40.0, 40.0) * p) + 0.5 * noise(vec3(5.0, 90.0, 90.0) * p) - 0.75;
  return 1.0 + grain_contrast * (0.25 - 0.95 * late + 0.6 * fibre);
}

// Two lattices that lie askew to each other and to the body show neither's squares.
float grains(vec3 p) {
  const mat3 askew = mat3(0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6);
  vec3 q = askew * p;
  return 0.5 * (noise(q) + noise(askew * q * 1.13 + 5.0));
}

float speckles(vec3 p) {
  float dark = smoothstep(0.57, 0.62, grains(15.0 * p));
  float light = smoothstep(0.56, 0.61, grains(19.0 * p + 17.0));
  float fine = grains(43.0 * p) - 0.5;
  return 1.0 + grain_contrast * (0.6 * light - 0.8 * dark + 0.5 * fine);
}

float veins(vec3 p) {
  float turbulent = 0.0, size = 1.0;
  for (int octave = 0; octave < 4; ++octave) {
    turbulent += abs(2.0 * noise(p * 2.0 / size + 7.0 * float(octave)) - 1.0) * size;
    size *= 0.5;
  }
  float band = abs(sin(2.2 * p.y + 1.3 * p.x + 3.4 * turbulent));
  return 1.0 - grain_contrast * (0.75 * pow(1.0 - band, 3.0) + 0.15 * (turbulent - 0.6));
}

vec3 grained(vec3 reflected, vec3 place) {
  if (grain_kind == 0) return reflected;
  vec3 p = grain_axes * place + grain_offset;
  float factor = grain_kind == 1 ? wood(p) : grain_kind == 2 ? speckles(p) : veins(p);
  // Dark parts of wood are redder, as their colour is the deeper one.
  vec3 deeper = grain_kind == 1 ? vec3(0.85, 1.0, 1.2) : vec3(1.0);
  return clamp(reflected * pow(vec3(max(factor, 0.05)), deeper), 0.0, 1.0);
}
)";

}  // namespace carillon::render
