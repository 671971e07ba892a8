#pragma once

namespace carillon::render {

/// Depth of the body seen from the key light.
inline constexpr const char* kShadowVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light_from_body;
void main() { gl_Position = light_from_body * vec4(position, 1.0); }
)";
inline constexpr const char* kShadowFragment = R"(#version 330 core
void main() {}
)";

/// One triangle over the whole picture.
inline constexpr const char* kBackgroundVertex = R"(#version 330 core
out float height;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = corner.y;
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";
inline constexpr const char* kBackgroundFragment = R"(#version 330 core
in float height;
out vec4 color;
void main() { color = vec4(vec3(mix(0.52, 0.80, 0.5 + 0.5 * height)), 1.0); }
)";

inline constexpr const char* kBodyVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 clip_from_body;
out vec3 body_position;
out vec3 body_normal;
void main() {
  body_position = position;
  body_normal = normal;
  gl_Position = clip_from_body * vec4(position, 1.0);
}
)";

/// Cook and Torrance with GGX (Walter et al. 2007), Smith's height-correlated masking (Heitz 2014)
/// and Schlick's Fresnel term; three directional lights, a studio of soft boxes as surroundings.
inline constexpr const char* kBodyFragment = R"(#version 330 core
in vec3 body_position;
in vec3 body_normal;
out vec4 color;
uniform mat4 light_from_body;
uniform vec3 eye;
uniform vec3 reflectance;
uniform float roughness;
uniform float metallic;
uniform vec3 light_direction[3];
uniform vec3 light_color[3];
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

vec3 fresnel(vec3 normal_incidence, float cosine) {
  return normal_incidence + (1.0 - normal_incidence) * pow(1.0 - cosine, 5.0);
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

void main() {
  vec3 v = normalize(eye - body_position);
  vec3 n = normalize(body_normal);
  if (!gl_FrontFacing) n = -n;
  float nv = max(dot(n, v), 1e-3);
  float alpha = max(roughness * roughness, 2e-3);
  float alpha2 = alpha * alpha;
  vec3 f0 = mix(vec3(0.04), reflectance, metallic);
  vec3 diffuse = reflectance * (1.0 - metallic);

  vec3 sum = vec3(0.0);
  for (int i = 0; i < 3; ++i) {
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
    vec3 light = light_color[i] * nl * (i == 0 ? lit_by_key(n) : 1.0);
    sum += ((1.0 - f) * diffuse + f * min(distribution * masking, 40.0)) * light;
  }
  // Surroundings: diffuse by the normal, mirrored by the reflected ray (Karis' fit of the
  // preintegrated reflectance, 2014).
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 fit = vec2(-1.04, 1.04) * a + r.zw;
  sum += diffuse * surroundings(n, 1.0);
  sum += (f0 * fit.x + fit.y) * surroundings(reflect(-v, n), roughness);
  // Highlights bend into white instead of being cut.
  vec3 over = max(sum - 0.75, 0.0);
  color = vec4(min(sum, 0.75) + 0.25 * (1.0 - exp(-over / 0.25)), 1.0);
}
)";

}  // namespace carillon::render
