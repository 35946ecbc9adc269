#version 300 es
// What is behind the scene: a soft gradient from top to bottom, and a faint disc on the floor.
precision highp float;

const float RADIUS = 0.7;     // of the disc, metres
const float EDGE = 0.02;      // half of the width of its rim, metres

uniform vec3 above;           // sRGB, straight up
uniform vec3 level;           // at the horizon
uniform vec3 below;           // straight down
uniform vec3 eye;             // in the room, metres
uniform vec2 feet;            // x and z of the room
uniform float disc;           // how much lighter the disc is; 0 for none
in vec3 ray;
out vec4 result;

void main() {
  vec3 d = normalize(ray);
  vec3 colour = mix(level, d.y > 0.0 ? above : below, smoothstep(0.0, 0.8, abs(d.y)));
  if (d.y < 0.0 && eye.y > 0.0) {
    float away = distance(eye.xz - d.xz * (eye.y / d.y), feet);
    float inside = 1.0 - smoothstep(RADIUS - EDGE, RADIUS, away);
    float rim = inside * smoothstep(RADIUS - 3.0 * EDGE, RADIUS - 2.0 * EDGE, away);
    colour += disc * (0.5 * inside + 0.5 * rim);
  }
  // A dim gradient has few steps of 8 bits, which a headset shows as rings: so they are scattered.
  float scatter = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  result = vec4(colour + (scatter - 0.5) / 255.0, 1.0);
}
