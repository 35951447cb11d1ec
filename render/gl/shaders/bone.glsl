// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal_in_bone;
layout(location = 2) in vec4 attributes;  // depth mm, above 0.5 reamed, density g/cm3, ambient accessibility 0..1

uniform mat4 clip_from_bone;
uniform mat4 eye_from_bone;
uniform vec4 cut_plane;  // clips points with a negative value

out vec3 normal;
out vec4 reaming;
out float behind_mm;

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  normal = mat3(eye_from_bone) * normal_in_bone;
  behind_mm = gl_ClipDistance[0];
  reaming = attributes;
}
#else
in vec3 normal;
in vec4 reaming;
out vec4 color;

uniform sampler2D depth_colors;
uniform float depth_max_mm;
uniform float haze_per_mm;  // fading of bone behind a section; 0: none

in float behind_mm;  // distance behind the cut plane; 1 without one

const vec3 kSoftBone = vec3(0.55, 0.39, 0.27);
const vec3 kDenseBone = vec3(0.80, 0.69, 0.53);
const vec3 kHaze = vec3(0.66, 0.70, 0.76);

void main() {
  if (!gl_FrontFacing) {
    // Only visible through the gap between a cut face and the surrounding surface.
    color = vec4(0.12, 0.13, 0.16, 1.0);
    return;
  }
  vec3 n = normalize(normal);
  float accessibility = reaming.w * reaming.w;
  float reamed = clamp((reaming.y - 0.5) / max(fwidth(reaming.y), 1e-5) + 0.5, 0.0, 1.0);

  vec3 bone = mix(kSoftBone, kDenseBone, smoothstep(0.2, 1.5, reaming.z));
  float fraction = clamp(reaming.x / depth_max_mm, 0.0, 1.0);
  float texels = float(textureSize(depth_colors, 0).x);
  vec3 map = linear_from_srgb(texture(depth_colors, vec2((fraction * (texels - 1.0) + 0.5) / texels, 0.5)).rgb);

  vec3 light = sky(n) * accessibility + kKeyColor * wrapped(n, key_direction, 0.25) * mix(0.6, 1.0, accessibility) +
               kFillColor * wrapped(n, kFillDirection, 0.35) * accessibility + kRimColor * wrapped(n, kRimDirection, 0.0);
  vec3 shine = highlight(n, key_direction, 0.48, vec3(0.04)) * kKeyColor * accessibility * 1.6;
  // Weak shading, so that the colours of the reamed face match the legend.
  vec3 even = mix(vec3(dot(light, vec3(0.3333))), vec3(1.02), 0.55);
  vec3 lit = mix(bone * light + shine, map * even + 0.3 * shine, reamed);
  // Haze far behind a section sets off the cut face.
  float haze = 0.62 * (1.0 - exp(-haze_per_mm * max(behind_mm, 0.0))) * (1.0 - reamed);
  color = vec4(srgb_from_linear(mix(lit, kHaze, haze)), 1.0);
}
#endif
