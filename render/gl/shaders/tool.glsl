// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#ifdef VERTEX
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
#else
in vec3 normal;
in vec3 tangent;
in vec2 across_mm;
out vec4 color;

uniform float opacity_facing;
uniform float opacity_edge;
uniform int brushed;  // opaque brushed steel instead of translucent

const vec3 kSteel = vec3(0.62, 0.65, 0.69);

// Environment map of a studio: bright ceiling panels, a dark horizon, a grey floor.
vec3 studio(vec3 r) {
  float panel = smoothstep(0.30, 0.42, r.y) * (1.0 - smoothstep(0.80, 0.92, r.y));
  float strip = smoothstep(0.45, 0.55, -r.x) * (1.0 - smoothstep(0.75, 0.85, -r.x));
  float horizon = smoothstep(0.0, 0.28, abs(r.y + 0.05));
  vec3 below = mix(vec3(0.40, 0.41, 0.43), vec3(0.10, 0.11, 0.13), smoothstep(0.0, 0.9, -r.y));
  vec3 above = vec3(0.34, 0.38, 0.43) + vec3(1.1) * panel;
  return mix(below, above, smoothstep(-0.03, 0.05, r.y)) * mix(0.6, 1.0, horizon) + vec3(0.8) * strip;
}

float hash(float x) { return fract(sin(x * 127.1) * 43758.5453); }

// Noise of the grooves, -1 to 1, which fades where it is finer than a pixel.
float grooves(float x) {
  float cell = floor(x);
  float value = 2.0 * mix(hash(cell), hash(cell + 1.0), smoothstep(0.0, 1.0, x - cell)) - 1.0;
  return value * (1.0 - smoothstep(0.25, 0.7, fwidth(x)));
}

// Steel brushed while it rotates: reflections are spread across the grooves.
vec3 brushed_steel(vec3 n) {
  vec3 along = tangent - n * dot(tangent, n);
  along = length(along) > 1e-4 ? normalize(along) : vec3(1.0, 0.0, 0.0);
  vec3 across = cross(n, along);
  float position = across_mm.x + across_mm.y;
  float groove = 0.6 * grooves(7.0 * position) + 0.4 * grooves(17.0 * position);
  vec3 mirrored = vec3(0.0);
  for (int i = -3; i <= 3; ++i) {
    vec3 tilted = normalize(n + across * (0.085 * float(i) + 0.03 * groove));
    mirrored += studio(reflect(vec3(0.0, 0.0, -1.0), tilted));
  }
  vec3 halfway = normalize(key_direction + vec3(0.0, 0.0, 1.0));
  float cosine = dot(along, halfway);
  // Kajiya and Kay 1989: a fibre has its highlight where the half vector is perpendicular to it.
  float shine = pow(max(1.0 - cosine * cosine, 0.0), 40.0) * max(dot(n, key_direction), 0.0);
  vec3 light = mirrored / 7.0 * 0.62 + sky(n) * 0.55 + kKeyColor * wrapped(n, key_direction, 0.2) * 0.30;
  return kSteel * (light * (1.0 + 0.10 * groove) + 0.45 * shine);
}

void main() {
  vec3 n = normalize(gl_FrontFacing ? normal : -normal);
  if (brushed == 1) {
    color = vec4(srgb_from_linear(brushed_steel(n)), 1.0);
    return;
  }
  float facing = clamp(abs(n.z), 0.0, 1.0);
  float fresnel = pow(1.0 - facing, 2.2);
  vec3 reflected = reflect(vec3(0.0, 0.0, -1.0), n);
  vec3 lit = kSteel * (studio(reflected) * 0.75 + sky(n) * 0.5) + highlight(n, key_direction, 0.32, kSteel) * 1.4;
  color = vec4(srgb_from_linear(lit), mix(opacity_facing, opacity_edge, fresnel));
}
#endif
