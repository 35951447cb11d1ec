in vec3 normal;
out vec4 color;

uniform float opacity_facing;
uniform float opacity_edge;
uniform int cut_open;

const vec3 kSteel = vec3(0.62, 0.65, 0.69);
const vec3 kCutSteel = vec3(0.42, 0.50, 0.60);

const float kHatch_px = 18.0;

// What polished steel mirrors in a studio: bright ceiling panels, a dark horizon, a grey floor.
vec3 studio(vec3 r) {
  float panel = smoothstep(0.30, 0.42, r.y) * (1.0 - smoothstep(0.80, 0.92, r.y));
  float strip = smoothstep(0.45, 0.55, -r.x) * (1.0 - smoothstep(0.75, 0.85, -r.x));
  float horizon = smoothstep(0.0, 0.28, abs(r.y + 0.05));
  vec3 below = mix(vec3(0.40, 0.41, 0.43), vec3(0.10, 0.11, 0.13), smoothstep(0.0, 0.9, -r.y));
  vec3 above = vec3(0.34, 0.38, 0.43) + vec3(1.1) * panel;
  return mix(below, above, smoothstep(-0.03, 0.05, r.y)) * mix(0.6, 1.0, horizon) + vec3(0.8) * strip;
}

void main() {
  if (cut_open == 1 && !gl_FrontFacing) {
    // Inside of a solid that is cut open: what is seen is its cut.
    float hatch = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / kHatch_px) - 0.5);
    color = vec4(srgb_from_linear(kCutSteel * (hatch < 0.06 ? 0.6 : 1.0)), 0.55);
    return;
  }
  vec3 n = normalize(gl_FrontFacing ? normal : -normal);
  float facing = clamp(abs(n.z), 0.0, 1.0);
  float fresnel = pow(1.0 - facing, 2.2);
  vec3 reflected = reflect(vec3(0.0, 0.0, -1.0), n);
  vec3 lit = kSteel * (studio(reflected) * 0.75 + sky(n) * 0.5) + highlight(n, kKeyDirection, 0.32, kSteel) * 1.4;
  color = vec4(srgb_from_linear(lit), mix(opacity_facing, opacity_edge, fresnel));
}
