// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The materials of bone and reamer: the shading of render/gl/shaders for WebGL 2. Light is in eye space; colours are linear until output.
import { DoubleSide, GLSL3, Group, LessEqualDepth, Mesh, NotEqualStencilFunc, ShaderMaterial, Vector3 } from "three";

const common = `
precision highp float;
const vec3 kKeyDirection = vec3(-0.509, 0.648, 0.574);
const vec3 kFillDirection = vec3(0.819, 0.102, 0.563);
const vec3 kKeyColor = vec3(0.92, 0.888, 0.828);
const vec3 kFillColor = vec3(0.115, 0.131, 0.16);
const vec3 kSkyColor = vec3(0.27, 0.285, 0.30);
const vec3 kGroundColor = vec3(0.096, 0.084, 0.072);

vec3 linear_from_srgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 srgb_from_linear(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
float wrapped(vec3 normal, vec3 direction, float wrap) { return max((dot(normal, direction) + wrap) / (1.0 + wrap), 0.0); }
`;

const mapColor = `
uniform vec3 stops[STOPS];
vec3 map_color(float fraction) {
  float place = clamp(fraction, 0.0, 1.0) * float(STOPS - 1);
  int lower = min(int(place), STOPS - 2);
  return mix(stops[lower], stops[lower + 1], place - float(lower));
}
`;

const boneVertex = `
in vec3 vertex_attributes;  // reamed 0..1, density over 2 g/cm3, ambient accessibility 0..1
in float depth;
in vec2 lift;               // bone that is still there: mm along the axis, and as a fraction
uniform vec3 lift_axis;
out vec3 eye_normal;
out vec4 reaming;  // depth over the legend's end, then as above
out vec3 place_mm;
void main() {
  place_mm = position + lift.x * lift_axis;
  float removed = 1.0 - lift.y;
  reaming = vec4(depth * removed, vertex_attributes);
  reaming.y *= smoothstep(0.0, 0.03, removed);
  eye_normal = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place_mm, 1.0);
}`;

const boneFragment = `${common}${mapColor}
in vec3 eye_normal;
in vec4 reaming;
in vec3 place_mm;
out vec4 color;
uniform vec4 cut;
uniform float depth_max_mm;
uniform float contour_mm;
uniform float shows_depth;

float contour(float depth_mm) {
  float steps = depth_mm / contour_mm;
  float width = max(fwidth(steps), 1e-6);
  float line = abs(fract(steps - 0.5) - 0.5) / width;
  float clear = (1.0 - smoothstep(0.15, 0.4, width)) * smoothstep(0.003, 0.010, width);
  return steps < 0.5 ? 0.0 : (1.0 - smoothstep(0.4, 1.3, line)) * clear;
}

void main() {
  if (dot(cut, vec4(place_mm, 1.0)) < 0.0) discard;
#ifdef COUNTS_FACES
  color = vec4(0.0);
  return;
#endif
  vec3 n = normalize(eye_normal);
  // The inside, seen through a cut; not the odd triangle that thinning has turned over.
  if (!gl_FrontFacing && n.z < -0.1) {
    color = vec4(0.12, 0.13, 0.16, 1.0);
    return;
  }
  float accessibility = reaming.w * reaming.w;
  float reamed = smoothstep(0.35, 0.65, reaming.y);
  vec3 bone = mix(vec3(0.55, 0.39, 0.27), vec3(0.80, 0.69, 0.53), smoothstep(0.1, 0.75, reaming.z));
  vec3 light = mix(kGroundColor, kSkyColor, 0.5 + 0.5 * n.y) * accessibility +
               kKeyColor * wrapped(n, kKeyDirection, 0.25) * mix(0.6, 1.0, accessibility) +
               kFillColor * wrapped(n, kFillDirection, 0.35) * accessibility;
  float halfway = max(dot(n, normalize(kKeyDirection + vec3(0.0, 0.0, 1.0))), 0.0);
  vec3 shine = 0.05 * pow(halfway, 24.0) * kKeyColor * accessibility;
  float depth_mm = reaming.x * depth_max_mm;
  vec3 map = linear_from_srgb(map_color(reaming.x)) * (1.0 - 0.35 * contour(depth_mm));
  // The reamed face must be readable against the legend, so shading only models its shape.
  vec3 even = mix(vec3(dot(light, vec3(0.3333))), vec3(1.02), 0.55);
  color = vec4(srgb_from_linear(mix(bone * light + shine, map * even + 0.3 * shine, reamed * shows_depth)), 1.0);
}`;

const capFragment = `
precision highp float;
precision highp sampler3D;
${mapColor}
in vec3 place_mm;
out vec4 color;
uniform sampler3D density;
uniform vec3 origin_mm;
uniform vec3 size_mm;
uniform float top_grade;  // of the colour map's end
void main() {
  float fraction = texture(density, (place_mm - origin_mm) / size_mm).r * 255.0 / top_grade;
  if (fraction == 0.0) discard;  // far from bone: where the count of faces slipped
  color = vec4(map_color(fraction), 1.0);
}`;

const placedVertex = `
out vec3 eye_normal;
out vec3 place_mm;  // in the bone frame
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  place_mm = place.xyz;
  eye_normal = normalMatrix * normal;
  gl_Position = projectionMatrix * viewMatrix * place;
}`;

const toolFragment = `${common}
in vec3 eye_normal;
in vec3 place_mm;
out vec4 color;
uniform vec4 cut;
uniform float has_cut;
uniform float opaque;
uniform vec3 tint;
uniform vec3 towards_viewer;  // in the bone frame
uniform float depth_per_mm;   // of the depth buffer

const vec3 kCutSteel = vec3(0.42, 0.50, 0.60);
const float kLift_mm = 0.02;  // towards the viewer, where bone and reamer touch

void main() {
  float kept_mm = dot(cut, vec4(place_mm, 1.0));
  if (kept_mm < 0.0) discard;
  float lift_mm = kLift_mm;
  float facing_cut = -dot(cut.xyz, towards_viewer);
  if (has_cut > 0.5 && !gl_FrontFacing && facing_cut > 0.0) {
    // A back face of a cut solid shows the cut, which lies in its plane.
    lift_mm += kept_mm / facing_cut;
    float hatch = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0) - 0.5);
    color = vec4(srgb_from_linear(kCutSteel * (hatch < 0.08 ? 0.55 : 1.0)), mix(0.55, 1.0, opaque));
  } else {
    vec3 n = normalize(gl_FrontFacing ? eye_normal : -eye_normal);
    vec3 halfway = normalize(kKeyDirection + vec3(0.0, 0.0, 1.0));
    vec3 light = mix(kGroundColor, kSkyColor, 0.5 + 0.5 * n.y) + kKeyColor * wrapped(n, kKeyDirection, 0.25) + kFillColor * wrapped(n, kFillDirection, 0.35);
    vec3 lit = tint * light + 0.5 * pow(max(dot(n, halfway), 0.0), 40.0) * kKeyColor;
    float edge = pow(1.0 - clamp(abs(n.z), 0.0, 1.0), 2.2);
    color = vec4(srgb_from_linear(lit), mix(mix(0.16, 0.8, edge), 1.0, opaque));
  }
  gl_FragDepth = gl_FragCoord.z - lift_mm * depth_per_mm;
}`;

const material = (vertexShader, fragmentShader, uniforms, more) =>
  new ShaderMaterial({ glslVersion: GLSL3, side: DoubleSide, vertexShader, fragmentShader, uniforms, ...more });

// With `counts`, it draws nothing, and the stencil buffer counts faces behind the cut.
export function boneMaterial(uniforms, counts = null) {
  const defines = { STOPS: uniforms.stops.value.length, ...(counts && { COUNTS_FACES: 1 }) };
  return material(boneVertex, boneFragment, uniforms, { defines, ...counts });
}

// Of the cut face, where faces were counted.
export const capMaterial = (uniforms) => material(placedVertex, capFragment, uniforms, {
  defines: { STOPS: uniforms.stops.value.length }, stencilWrite: true, stencilFunc: NotEqualStencilFunc,
});

// The look of a reamer: uniforms, and what makes a model of a geometry. Its nearest faces alone are drawn, so that its walls
// do not add up, and after the bone. `tint` is linear.
export function toolLook(tint, cut) {
  const uniforms = {
    cut: { value: cut }, has_cut: { value: 0 }, opaque: { value: 0 }, tint: { value: tint },
    towards_viewer: { value: new Vector3(0, 0, 1) }, depth_per_mm: { value: 0 },
  };
  const onBeforeRender = (renderer, scene, camera) => {
    camera.getWorldDirection(uniforms.towards_viewer.value).negate();
    uniforms.depth_per_mm.value = 1 / (camera.far - camera.near);
  };
  const materials = [{ colorWrite: false }, { depthWrite: false }].map((more) =>
    material(placedVertex, toolFragment, uniforms, { depthFunc: LessEqualDepth, transparent: true, onBeforeRender, ...more }));
  const modelOf = (geometry) => new Group().add(...materials.map((made, i) =>
    Object.assign(new Mesh(geometry, made), { renderOrder: 10 + i, frustumCulled: false })));
  return { uniforms, modelOf };
}
