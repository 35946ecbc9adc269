/** The file of a picture. */

import type { Pixels } from "../renderer/shot";

/**
 * Encode pixels.
 *
 * @param type such as `image/png` or `image/jpeg`.
 */
export function pictureFile({ width, height, data }: Pixels, type: string): Promise<Blob> {
  const canvas = new OffscreenCanvas(width, height);
  const picture = new ImageData(new Uint8ClampedArray(data), width, height);
  canvas.getContext("2d")?.putImageData(picture, 0, 0);
  return canvas.convertToBlob({ type, quality: 0.92 });
}
