// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#version 450 core
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
