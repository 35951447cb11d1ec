// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#version 450 core
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal_in_bone;
layout(location = 2) in vec4 attributes;  // depth mm, above 0.5 reamed, density g/cm3, ambient accessibility 0..1

uniform mat4 clip_from_bone;
uniform mat4 eye_from_bone;
uniform vec4 cut_plane;  // clips points with a negative value

out vec3 normal;
out vec4 reaming;
out float behind_mm;

void main() {
  gl_Position = clip_from_bone * vec4(position_mm, 1.0);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  normal = mat3(eye_from_bone) * normal_in_bone;
  behind_mm = gl_ClipDistance[0];
  reaming = attributes;
}
