// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
// One triangle in the cut plane that covers the picture; no vertex buffer.
uniform vec4 plane_in_clip;  // zero on the cut plane, clip coordinates
uniform float depth_offset;  // towards the viewer: in front of the cut face of the bone

void main() {
  vec2 place = 2.0 * vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2)) - 1.0;
  float depth = -(dot(plane_in_clip.xy, place) + plane_in_clip.w) / plane_in_clip.z;
  gl_Position = vec4(place, depth - depth_offset, 1.0);
  gl_ClipDistance[0] = 1.0;
}
#else
out vec4 color;

const vec3 kCutSteel = vec3(0.42, 0.50, 0.60);
const float kHatch_px = 18.0;  // of the output picture

void main() {
  float hatch = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / (kHatch_px * samples_per_px)) - 0.5);
  color = vec4(srgb_from_linear(kCutSteel * (hatch < 0.06 ? 0.6 : 1.0)), 1.0);
}
#endif
