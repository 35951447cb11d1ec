// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

out vec4 color;

const vec3 kCutSteel = vec3(0.42, 0.50, 0.60);
const float kHatch_px = 18.0;  // of the output picture

void main() {
  float hatch = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / (kHatch_px * samples_per_px)) - 0.5);
  color = vec4(srgb_from_linear(kCutSteel * (hatch < 0.06 ? 0.6 : 1.0)), 1.0);
}
