in vec2 place;
out vec4 color;

uniform float opacity;

void main() {
  float edge = max(fwidth(place.x), 1e-4);
  float cover = clamp((1.0 - abs(place.x)) / edge, 0.0, 1.0);
  color = vec4(mix(vec3(0.05, 0.07, 0.10), vec3(1.0), place.y), opacity * cover);
}
