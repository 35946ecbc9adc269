#version 300 es
uniform mat4 clip;            // quad to clip space; the quad's corners are (0, 0) and (1, 1)
out vec2 place;

void main() {
  place = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  gl_Position = clip * vec4(place, 0.0, 1.0);
}
