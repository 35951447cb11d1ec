// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#version 450 core
// One triangle that covers the picture; no vertex buffer.
out vec2 picture;

void main() {
  picture = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(picture * 2.0 - 1.0, 0.0, 1.0);
  gl_ClipDistance[0] = 1.0;
}
