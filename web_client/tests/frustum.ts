/** A projection as of OpenGL's glFrustum, by columns; edges on the near plane at 0.1. */
export function frustum(left: number, right: number, bottom: number, top: number): Float32Array {
  const [near, far] = [0.1, 100];
  // biome-ignore format: a matrix, by columns
  return new Float32Array([
    (2 * near) / (right - left), 0, 0, 0,
    0, (2 * near) / (top - bottom), 0, 0,
    (right + left) / (right - left), (top + bottom) / (top - bottom), -(far + near) / (far - near), -1,
    0, 0, (-2 * far * near) / (far - near), 0,
  ]);
}
