// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#version 450 core
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec2 texture_coordinates;

uniform mat4 clip_from_bone;

out vec2 uv;

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = 1.0;
  uv = texture_coordinates;
}
