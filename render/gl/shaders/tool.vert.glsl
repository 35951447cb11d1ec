#version 450 core
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal_in_tool;

uniform mat4 clip_from_tool;
uniform mat4 eye_from_tool;
uniform vec4 cut_plane;     // in the tool frame; what has a negative value is cut away
uniform float towards_eye;  // in clip units times w: keeps the tool's face in front of the bone that it has just cut

out vec3 normal;
out vec3 round_axis;  // the way that the brush went: round the spin axis, in eye space
out vec2 across_mm;   // where in the brush's grooves: distance from the spin axis, and height

void main() {
  gl_Position = clip_from_tool * vec4(position_mm, 1.0);
  gl_Position.z -= towards_eye / max(gl_Position.w, 0.01);
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  normal = mat3(eye_from_tool) * normal_in_tool;
  round_axis = mat3(eye_from_tool) * vec3(-position_mm.y, position_mm.x, 0.0);
  across_mm = vec2(length(position_mm.xy), position_mm.z);
}
