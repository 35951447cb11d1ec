// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec2 ribbon;  // place across it -1..1, brightness

uniform mat4 clip_from_bone;
uniform vec4 cut_plane;  // clips points with a negative value

out vec2 place;

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  place = ribbon;
}
#else
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
#endif
