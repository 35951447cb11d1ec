// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
// One triangle that covers the picture; no vertex buffer.
out vec2 picture;

void main() {
  picture = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(picture * 2.0 - 1.0, 0.0, 1.0);
  gl_ClipDistance[0] = 1.0;
}
#else
in vec2 picture;
out vec4 color;

const vec3 kTop = vec3(0.957, 0.965, 0.976);
const vec3 kBottom = vec3(0.800, 0.831, 0.863);

uniform int white;

void main() { color = vec4(white == 1 ? vec3(1.0) : mix(kBottom, kTop, smoothstep(0.0, 1.0, picture.y)), 1.0); }
#endif
