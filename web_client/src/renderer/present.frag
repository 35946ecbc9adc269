#version 300 es
// Copies a picture to the canvas: exactly at equal sizes, else interpolated.
precision highp float;

uniform highp sampler2D picture;
uniform vec2 size;            // of the canvas
out vec4 result;

void main() {
  result = vec4(texture(picture, gl_FragCoord.xy / size).rgb, 1.0);
}
