// Added to renderer/splat.vert where a host draws: the host's depth and light.
uniform vec4 depthZ;          // these take a point before the camera, and 1, to the host's clip-space z and w
uniform vec4 depthW;
uniform float logarithmic;    // the host's factor for logarithms of depth; 0 if its depth has none
uniform bool linear;          // colours in linear light
uniform float exponent;       // from colours to linear light; 0 for the curve of sRGB

void surround(vec3 p, vec3 paint) {
  float clipW = dot(depthW, vec4(p, 1.0));
  gl_Position.z = logarithmic > 0.0 ? logarithmic * log2(1.0 + clipW) - 1.0 : dot(depthZ, vec4(p, 1.0)) / clipW;
  if (linear) {
    vec3 steep = pow((max(paint, 0.0) + 0.055) / 1.055, vec3(2.4));
    colour.rgb = exponent > 0.0 ? pow(max(paint, 0.0), vec3(exponent)) : mix(paint / 12.92, steep, step(0.04045, paint));
  }
}
