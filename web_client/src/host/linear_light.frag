#version 300 es
// Draws a copy over its original, with the colours converted from or into linear light; brighter than white is kept.
precision highp float;

uniform highp sampler2D picture;
uniform bool linear;          // the direction: into linear light, else from it
out vec4 result;

void main() {
  result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  vec3 c = max(result.rgb, 0.0);
  result.rgb = linear
    ? mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c))
    : mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
