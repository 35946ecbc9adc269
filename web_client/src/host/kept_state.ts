/**
 * The preservation of state that drawing and filling splats changes in a host's context. Blending, depth, culling and
 * masks are not part of it: the host itself has set them by the material of the splats.
 */

/** Texture units of the drawer, from the first. */
const UNITS = [0, 1, 2, 3] as const;

/** Parameters for reading rows of texels, with the drawer's values. */
const UNPACKING = [
  ["UNPACK_ALIGNMENT", 4],
  ["UNPACK_ROW_LENGTH", 0],
  ["UNPACK_SKIP_PIXELS", 0],
  ["UNPACK_SKIP_ROWS", 0],
  ["UNPACK_FLIP_Y_WEBGL", false],
  ["UNPACK_PREMULTIPLY_ALPHA_WEBGL", false],
] as const;

/** Run a function that draws, then restore the bindings. */
export function keepBindings<T>(gl: WebGL2RenderingContext, draw: () => T): T {
  const program = gl.getParameter(gl.CURRENT_PROGRAM);
  const vertexArray = gl.getParameter(gl.VERTEX_ARRAY_BINDING);
  const dither = gl.isEnabled(gl.DITHER);
  const active = gl.getParameter(gl.ACTIVE_TEXTURE);
  const units = UNITS.map((unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    const sampler = gl.getParameter(gl.SAMPLER_BINDING);
    if (sampler) gl.bindSampler(unit, null); // one that interpolates would read nothing
    return { unit, sampler, texture: gl.getParameter(gl.TEXTURE_BINDING_2D) };
  });
  try {
    return draw();
  } finally {
    for (const { unit, sampler, texture } of units) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      if (sampler) gl.bindSampler(unit, sampler);
    }
    gl.activeTexture(active);
    if (dither) gl.enable(gl.DITHER);
    gl.bindVertexArray(vertexArray);
    gl.useProgram(program);
  }
}

/** Run a function that creates and fills textures and buffers, then restore the host's parameters. */
export function keepUnpacking<T>(gl: WebGL2RenderingContext, fill: () => T): T {
  const values = UNPACKING.map(([name]) => gl.getParameter(gl[name]));
  const buffer = gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING);
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  for (const [name, value] of UNPACKING) gl.pixelStorei(gl[name], value);
  try {
    return keepBindings(gl, fill);
  } finally {
    UNPACKING.forEach(([name], i) => {
      gl.pixelStorei(gl[name], values[i]);
    });
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
  }
}
