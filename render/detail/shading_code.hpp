#pragma once

namespace carillon::render {

inline constexpr const char* glsl_version = "#version 330 core\n";

/// After the version: what a surface sends back of a studio's light. The studio is a dome above a
/// horizon, what the floor sends back below it, and three soft boxes: a key, which casts shadows, a
/// fill and a rim. Directions are unit vectors in the world.
///
/// A mirror direction is looked up in the studio as a rough surface blurs it. The slopes of GGX
/// (Walter et al. 2007) along one axis have the cumulative distribution 1/2 + t / (2 sqrt(1 +
/// t^2)), t = slope / alpha, and a ray turns by twice its facet: the edge of a box, or the horizon,
/// at a tangent x is blurred by t = x / (2 alpha). What a surface reflects of it is the directional
/// albedo of Cook and Torrance's model with GGX (split sum, in Karis' fit of 2014). Light that
/// bounces between facets is given back by the factor 1 + f0 (1 / E - 1) (Turquin 2019), and what
/// is scattered below the surface is what is not reflected at it, so that a white body in even
/// light is as bright as this.
///
/// `coat` is a layer of clear glaze or varnish with an index of 1.5 (clear coat of glTF 2.0).
inline constexpr const char* shading = R"(
uniform float roughness;
uniform float metallic;
uniform float transmission;
uniform float coat;
uniform vec3 sky_light;       // radiance above the horizon
uniform vec3 floor_light;     // and below it
uniform mat3 box_axes[3];     // of key, fill and rim; columns: sideways, up, towards the box
uniform vec2 box_half[3];     // tangents of half their width and height
uniform vec3 box_light[3];    // irradiance over pi at normal incidence
uniform vec3 box_radiance[3];

const float coat_roughness = 0.12;
const float soft_edge = 0.03;  // of a box, as a tangent

float spread(float t) { return t * inversesqrt(1.0 + t * t); }

float box_seen(int box, vec3 direction, float blur) {
  vec3 q = direction * box_axes[box];
  if (q.z <= 0.0) return 0.0;
  vec2 x = q.xy / q.z, h = box_half[box];
  float scale = 1.0 / (blur + soft_edge);
  return 0.25 * (spread((h.x - x.x) * scale) + spread((h.x + x.x) * scale)) *
         (spread((h.y - x.y) * scale) + spread((h.y + x.y) * scale));
}

// Radiance from a direction, of which `lit` is the part of the key that is not in shadow, and
// `open` that of the rest.
vec3 studio(vec3 direction, float rough, float lit, float open) {
  float blur = 2.0 * rough * rough;
  float above = 0.5 + 0.5 * spread(direction.z / (blur + 0.08));
  vec3 light = mix(floor_light, sky_light, above);
  light += box_radiance[1] * box_seen(1, direction, blur);
  light += box_radiance[2] * box_seen(2, direction, blur);
  return open * light + lit * box_radiance[0] * box_seen(0, direction, blur);
}

// Cosine of the part of a wide lamp that is above a surface.
float lambert(float cosine, float half_width) {
  float up = clamp(cosine + half_width, 0.0, 2.0 * half_width);
  return cosine > half_width ? cosine : up * up / (4.0 * half_width);
}

// Irradiance over pi.
vec3 irradiance(vec3 n, float lit, float open) {
  vec3 light = mix(floor_light, sky_light, 0.5 + 0.5 * n.z);
  for (int i = 1; i < 3; ++i) {
    light += box_light[i] * lambert(dot(n, box_axes[i][2]), box_half[i].y);
  }
  return open * light + lit * box_light[0] * lambert(dot(n, box_axes[0][2]), box_half[0].y);
}

// Directional albedo of GGX: what a mirror of f0 = 1 reflects is x + y, of f0 = 0 y.
vec2 albedo(float rough, float nv) {
  vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  return vec2(-1.04, 1.04) * a + r.zw;
}

// Highlights bend into white instead of being cut.
vec3 toned(vec3 light) {
  vec3 over = max(light - 0.7, 0.0);
  return min(light, 0.7) + 0.3 * (1.0 - exp(-over / 0.3));
}

// Light towards v of a surface with normal n. `through`: what is let through comes from there.
vec3 shade(vec3 n, vec3 v, vec3 reflectance, float rough, float lit, float open, vec3 through) {
  float nv = max(dot(n, v), 1e-3);
  vec3 f0 = mix(vec3(0.04), reflectance, metallic);
  vec2 split = albedo(rough, nv);
  vec3 mirrored = (f0 * split.x + split.y) * (1.0 + f0 * (1.0 / (split.x + split.y) - 1.0));
  // What keeps light from all around keeps less from a narrow mirror direction (Lagarde 2014).
  float mirror_open = clamp(pow(nv + open, exp2(-16.0 * rough - 1.0)) - 1.0 + open, 0.0, 1.0);
  vec3 r = reflect(-v, n);
  float within = 1.0 - max(mirrored.r, max(mirrored.g, mirrored.b));
  float solid = (1.0 - metallic) * within;
  vec3 sum = mirrored * studio(r, rough, lit, mirror_open);
  sum += solid * (1.0 - transmission) * reflectance * irradiance(n, lit, open);
  sum += solid * transmission * through;
  if (coat > 0.0) {
    vec2 glaze = albedo(coat_roughness, nv);
    float clear = coat * (0.04 * glaze.x + glaze.y);
    sum = (1.0 - clear) * sum + clear * studio(r, coat_roughness, lit, mirror_open);
  }
  return sum;
}
)";

}  // namespace carillon::render
