#version 300 es
precision highp float;

uniform sampler2D picture;    // multiplied by alpha, rows from the bottom
uniform vec4 colour;          // multiplied by alpha; alpha 0 draws the picture instead
in vec2 place;
out vec4 result;

void main() {
  result = colour.a > 0.0 ? colour : texture(picture, place);
}
