#version 300 es
// One triangle that covers the picture; for each of its pixels a ray in the room.
uniform mat4 projection;      // eye to clip space
uniform mat4 eyeFromRoom;
out vec3 ray;

void main() {
  vec2 at = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 4.0 - 1.0;
  vec3 own = vec3((at.x + projection[2].x) / projection[0].x, (at.y + projection[2].y) / projection[1].y, -1.0);
  ray = transpose(mat3(eyeFromRoom)) * own;
  gl_Position = vec4(at, 0.0, 1.0);
}
