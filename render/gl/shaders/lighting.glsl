// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Before the text of each shader: light in eye space (x right, y up, z towards the viewer), linear colours.
uniform vec3 key_direction;  // towards the key light
uniform float samples_per_px;  // along a side; 1 without supersampling

const vec3 kFillDirection = normalize(vec3(0.80, 0.10, 0.55));
const vec3 kRimDirection = normalize(vec3(0.35, 0.55, -0.65));
const vec3 kKeyColor = vec3(1.00, 0.965, 0.90) * 0.92;
const vec3 kFillColor = vec3(0.72, 0.82, 1.00) * 0.16;
const vec3 kRimColor = vec3(0.90, 0.95, 1.00) * 0.30;
const vec3 kSkyColor = vec3(0.90, 0.95, 1.00) * 0.30;
const vec3 kGroundColor = vec3(0.80, 0.70, 0.60) * 0.12;

vec3 linear_from_srgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }

vec3 srgb_from_linear(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

// Wrapped diffuse light, an approximation of subsurface scattering.
float wrapped(vec3 normal, vec3 direction, float wrap) { return max((dot(normal, direction) + wrap) / (1.0 + wrap), 0.0); }

vec3 sky(vec3 normal) { return mix(kGroundColor, kSkyColor, 0.5 + 0.5 * normal.y); }

// GGX highlight of reflectance f0, seen along +z.
vec3 highlight(vec3 normal, vec3 direction, float roughness, vec3 f0) {
  vec3 view = vec3(0.0, 0.0, 1.0);
  vec3 halfway = normalize(direction + view);
  float nl = max(dot(normal, direction), 0.0);
  float nv = max(normal.z, 0.05);
  float nh = max(dot(normal, halfway), 0.0);
  float a2 = roughness * roughness * roughness * roughness;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float distribution = a2 / (3.14159265 * d * d);
  float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
  float visibility = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
  vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(halfway, view), 0.0), 5.0);
  return distribution * visibility * nl * fresnel;
}
