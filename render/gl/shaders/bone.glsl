// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
// Lit by the vertex: triangles are a few pixels large, and a software rasteriser shades blocks of 16 pixels for each.
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal_in_bone;
layout(location = 2) in vec4 attributes;  // depth mm, above 0.5 reamed, density g/cm3, ambient accessibility 0..1

uniform mat4 clip_from_bone;
uniform mat4 eye_from_bone;
uniform vec4 cut_plane;  // clips points with a negative value
uniform sampler2D depth_colors;
uniform float depth_max_mm;
uniform float haze_per_mm;  // fading of bone behind a section; 0: none

out vec3 bone;  // colour of unreamed bone
out vec3 face;  // colour of the reamed face
out float reamed;

const vec3 kSoftBone = vec3(0.55, 0.39, 0.27);
const vec3 kDenseBone = vec3(0.80, 0.69, 0.53);
const vec3 kHaze = vec3(0.66, 0.70, 0.76);

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));  // distance behind the cut plane; 1 without one
  reamed = attributes.y;
  vec3 n = normalize(mat3(eye_from_bone) * normal_in_bone);
  float accessibility = attributes.w * attributes.w;
  vec3 light = sky(n) * accessibility + kKeyColor * wrapped(n, key_direction, 0.25) * mix(0.6, 1.0, accessibility) +
               kFillColor * wrapped(n, kFillDirection, 0.35) * accessibility + kRimColor * wrapped(n, kRimDirection, 0.0);
  vec3 shine = highlight(n, key_direction, 0.48, vec3(0.04)) * kKeyColor * accessibility * 1.6;
  // Haze far behind a section sets off the cut face.
  float haze = 0.62 * (1.0 - exp(-haze_per_mm * max(gl_ClipDistance[0], 0.0)));
  vec3 lit = mix(kSoftBone, kDenseBone, smoothstep(0.2, 1.5, attributes.z)) * light + shine;
  bone = srgb_from_linear(mix(lit, kHaze, haze));

  float fraction = clamp(attributes.x / depth_max_mm, 0.0, 1.0);
  float texels = float(textureSize(depth_colors, 0).x);
  vec3 map = linear_from_srgb(texture(depth_colors, vec2((fraction * (texels - 1.0) + 0.5) / texels, 0.5)).rgb);
  // Weak shading, so that the colours of the reamed face match the legend.
  vec3 even = mix(vec3(dot(light, vec3(0.3333))), vec3(1.02), 0.55);
  face = srgb_from_linear(map * even + 0.3 * shine);
}
#else
in vec3 bone;
in vec3 face;
in float reamed;
out vec4 color;

void main() {
  // Back faces are only visible through the gap between a cut face and the surrounding surface.
  float edge = clamp((reamed - 0.5) / max(fwidth(reamed), 1e-5) + 0.5, 0.0, 1.0);
  color = vec4(gl_FrontFacing ? mix(bone, face, edge) : vec3(0.12, 0.13, 0.16), 1.0);
}
#endif
