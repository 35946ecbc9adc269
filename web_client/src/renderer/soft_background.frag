#version 300 es
// A soft gradient from straight below through the horizon to straight above.
precision highp float;

uniform vec3 below;           // sRGB
uniform vec3 level;
uniform vec3 above;
uniform vec3 up;              // in camera space
uniform vec4 lens;            // focal lengths, and principal point from the bottom left, pixels
out vec4 result;

void main() {
  vec3 ray = vec3((gl_FragCoord.xy - lens.zw) / lens.xy * vec2(1.0, -1.0), 1.0);
  float height = dot(normalize(ray), up);
  vec3 colour = mix(level, height > 0.0 ? above : below, smoothstep(0.0, 0.8, abs(height)));
  // A dim gradient has few steps of 8 bits, which show as bands: so they are scattered.
  float scatter = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  result = vec4(colour + (scatter - 0.5) / 255.0, 1.0);
}
