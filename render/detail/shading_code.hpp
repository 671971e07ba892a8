#pragma once

namespace carillon::render {

inline constexpr const char* glsl_version = "#version 330 core\n";

/// After the version, and LIGHTS where there are not three of them: what a surface sends back. Cook
/// and Torrance with GGX (Walter et al. 2007), Smith's height-correlated masking (Heitz 2014) and
/// Schlick's Fresnel term; three directional lights, of which `lit` is the part of the first that
/// is not in shadow; a studio of soft boxes as surroundings. n and v: unit vectors of the normal
/// and to the eye. What a clear body lets through is a light backdrop, where the ray that is
/// refracted as it enters (an index of 1.5) meets it, tinted by the body's colour the more the
/// longer its way in a wall: nothing that lies behind the body is seen through it.
inline constexpr const char* shading = R"(
#ifndef LIGHTS
#define LIGHTS 3
#endif
uniform float roughness;
uniform float metallic;
uniform float transmission;
uniform vec3 light_direction[LIGHTS];
uniform vec3 light_color[LIGHTS];

vec3 fresnel(vec3 normal_incidence, float cosine) {
  return normal_incidence + (1.0 - normal_incidence) * pow(max(1.0 - cosine, 0.0), 5.0);
}

// Light from the surroundings, blurred as the surface is rough: dim floor, bright ceiling, a band
// of light at the horizon for smooth metal to mirror.
vec3 surroundings(vec3 direction, float blur) {
  float width = 0.30 + 0.70 * blur;
  float sky = smoothstep(-width, width, direction.z);
  float band = exp(-pow((direction.z - 0.35) / (0.18 + blur), 2.0)) * (1.0 - 0.8 * blur);
  vec3 floor_light = vec3(0.15, 0.147, 0.14) * (1.0 - 0.4 * direction.z);
  return mix(floor_light, vec3(0.34, 0.355, 0.375), sky) + 0.42 * band;
}

vec3 shade(vec3 n, vec3 v, vec3 reflectance, float lit) {
  float nv = max(dot(n, v), 1e-3);
  float alpha = max(roughness * roughness, 2e-3);
  float alpha2 = alpha * alpha;
  vec3 f0 = mix(vec3(0.04), reflectance, metallic);
  float cleared = transmission * (1.0 - metallic);
  vec3 diffuse = reflectance * (1.0 - metallic) * (1.0 - transmission);

  vec3 sum = vec3(0.0);
  for (int i = 0; i < LIGHTS; ++i) {
    vec3 l = light_direction[i];
    float nl = dot(n, l);
    if (nl <= 0.0) continue;
    vec3 h = normalize(l + v);
    float nh = max(dot(n, h), 0.0);
    float t = nh * nh * (alpha2 - 1.0) + 1.0;
    float distribution = alpha2 / (t * t);
    float masking = 0.5 / (nl * sqrt(nv * nv * (1.0 - alpha2) + alpha2) +
                           nv * sqrt(nl * nl * (1.0 - alpha2) + alpha2));
    vec3 f = fresnel(f0, max(dot(h, v), 0.0));
    vec3 light = light_color[i] * nl * (i == 0 ? lit : 1.0);
    sum += ((1.0 - f) * diffuse + f * min(distribution * masking, 40.0)) * light;
  }
  // Surroundings: diffuse by the normal, mirrored by the reflected ray (Karis' fit of the
  // preintegrated reflectance, 2014).
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 fit = vec2(-1.04, 1.04) * a + r.zw;
  sum += diffuse * surroundings(n, 1.0);
  vec3 mirrored = f0 * fit.x + fit.y;
  sum += mirrored * surroundings(reflect(-v, n), roughness);
  if (cleared > 0.0) {
    vec3 through = refract(-v, n, 1.0 / 1.5);
    vec3 behind = vec3(mix(0.42, 1.0, clamp(0.5 + 0.8 * through.z, 0.0, 1.0)));
    for (int i = 0; i < LIGHTS; ++i) {
      behind += light_color[i] * pow(max(dot(through, light_direction[i]), 0.0), 8.0);
    }
    vec3 tint = pow(reflectance, vec3(1.0 + 3.0 * (1.0 - nv) * (1.0 - nv)));
    sum += cleared * tint * (1.0 - mirrored) * behind;
  }
  // Highlights bend into white instead of being cut.
  vec3 over = max(sum - 0.75, 0.0);
  return min(sum, 0.75) + 0.25 * (1.0 - exp(-over / 0.25));
}
)";

}  // namespace carillon::render
