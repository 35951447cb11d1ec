// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#version 450 core
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal_in_tool;

uniform mat4 clip_from_tool;
uniform mat4 eye_from_tool;
uniform vec4 cut_plane;     // tool frame; clips points with a negative value
uniform float depth_offset;  // clip units times w, towards the viewer: against z-fighting with the bone

out vec3 normal;
out vec3 tangent;    // direction of brushing about the spin axis, eye space
out vec2 across_mm;  // position across the grooves: distance from the spin axis, height

void main() {
  gl_Position = clip_from_tool * vec4(position_mm, 1.0);
  gl_Position.z -= depth_offset / max(gl_Position.w, 0.01);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  normal = mat3(eye_from_tool) * normal_in_tool;
  tangent = mat3(eye_from_tool) * vec3(-position_mm.y, position_mm.x, 0.0);
  across_mm = vec2(length(position_mm.xy), position_mm.z);
}
