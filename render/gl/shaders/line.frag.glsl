// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

in vec2 place;
out vec4 color;

uniform float opacity;
uniform float half_width_px;  // of the line; the ribbon is half a pixel wider on each side

void main() {
  // The mean over a pixel does not depend on the number of samples.
  float off_px = abs(place.x) * (half_width_px + 0.5);
  float cover = clamp((half_width_px - off_px) * samples_per_px + 0.5, 0.0, 1.0);
  color = vec4(mix(vec3(0.05, 0.07, 0.10), vec3(1.0), place.y), opacity * cover);
}
