// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec2 texture_coordinates;

uniform mat4 clip_from_bone;

out vec2 uv;

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = 1.0;
  uv = texture_coordinates;
}
#else
in vec2 uv;
out vec4 color;

uniform sampler2D face;  // density g/cm3, bone fraction minus a half
uniform sampler2D density_colors;
uniform float density_max_g_cm3;

void main() {
  vec2 texel = texture(face, uv).rg;
  float width = max(fwidth(texel.g), 1e-5);
  float cover = clamp(texel.g / width + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  float texels = float(textureSize(density_colors, 0).x);
  float x = clamp(texel.r / density_max_g_cm3, 0.0, 1.0);
  vec3 map = texture(density_colors, vec2((x * (texels - 1.0) + 0.5) / texels, 0.5)).rgb;
  // A dark outline of about two pixels separates dense bone from a light background.
  float edge = 1.0 - smoothstep(1.5, 2.8, texel.g / (width * samples_per_px));
  color = vec4(mix(map, vec3(0.12, 0.13, 0.16), 0.85 * edge), cover);
}
#endif
