in vec2 at;
out vec4 color;

uniform sampler2D face;  // density g/cm3, share of bone less a half
uniform sampler2D density_colors;
uniform float density_max_g_cm3;

void main() {
  vec2 here = texture(face, at).rg;
  float width = max(fwidth(here.g), 1e-5);
  float cover = clamp(here.g / width + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  float texels = float(textureSize(density_colors, 0).x);
  float x = clamp(here.r / density_max_g_cm3, 0.0, 1.0);
  vec3 map = texture(density_colors, vec2((x * (texels - 1.0) + 0.5) / texels, 0.5)).rgb;
  // A dark line of about two pixels along the edge, so that dense bone stands out from a light background.
  float edge = 1.0 - smoothstep(1.5, 2.8, here.g / (width * samples_per_px));
  color = vec4(mix(map, vec3(0.12, 0.13, 0.16), 0.85 * edge), cover);
}
