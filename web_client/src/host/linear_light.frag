#version 300 es
// Draws a copy over its original, with the colours converted from or into linear light; brighter than white is kept.
precision highp float;

uniform highp sampler2D picture;
uniform bool linear;          // the direction: into linear light, else from it
uniform float exponent;       // from colours to linear light; 0 for the curve of sRGB
out vec4 result;

void main() {
  result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  vec3 c = max(result.rgb, 0.0);
  if (exponent > 0.0) result.rgb = pow(c, vec3(linear ? exponent : 1.0 / exponent));
  else result.rgb = linear
    ? mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c))
    : mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
