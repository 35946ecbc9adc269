/** How splats lie in the data textures; shared by the worker that packs them and the shaders that read them. */

/** Texels per row of every data texture; a power of two. */
export const TEXTURE_WIDTH = 2048;

/** RGBA32F texels of a static splat: [x y z opacity] [quaternion] [sigma x y z, -] [r g b, -]. */
export const STATIC_TEXELS = 4;

/** RGBA32F texels of a dynamic splat: 3 of motion, 2 of rotation, [sigma, peak opacity] [r g b, mu] [s, -, -, -]. */
export const DYNAMIC_TEXELS = 8;

export const STATICS_PER_ROW = TEXTURE_WIDTH / STATIC_TEXELS;
export const DYNAMICS_PER_ROW = TEXTURE_WIDTH / DYNAMIC_TEXELS;

/** Set in the ids of dynamic splats. */
export const DYNAMIC_BIT = 0x80000000;

/** Quads drawn by one instance: many, because small instances starve GPUs, and 4 x 1,024 vertices need 16-bit indices. */
export const QUADS_PER_INSTANCE = 1024;
