#version 300 es
// Evaluates the Gaussian at the pixel's centre from the exact screen mean, not from interpolated corners: those snap to
// a subpixel grid.
precision highp float;

const float LEAST = -7.9943534;   // log2(1 / 255)

flat in vec2 middle;
flat in vec3 falloff;
flat in vec4 colour;
out vec4 result;

void main() {
  vec2 delta = gl_FragCoord.xy - middle;
  vec2 deviations = vec2(falloff.x * (delta.x + falloff.y * delta.y), falloff.z * delta.y);
  float power = colour.a - dot(deviations, deviations);
  if (power < LEAST) discard;
  float alpha = min(0.99, exp2(power));
  result = vec4(colour.rgb * alpha, alpha);
}
