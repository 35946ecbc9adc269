/** Decoded chunks as texels of the data textures, in the layout of renderer/layout.ts. */

import type { DynamicChunk, StaticChunk } from "../codec/types";
import {
  DYNAMIC_TEXELS,
  DYNAMICS_PER_ROW,
  FIFTH_TEXELS,
  FIFTH_WIDTH,
  STATIC_TEXELS,
  STATICS_PER_ROW,
  TEXTURE_WIDTH,
} from "../renderer/layout";

const allocate = (count: number, perRow: number, width = TEXTURE_WIDTH) =>
  new Float32Array(Math.ceil(count / perRow) * width * 4);

const CUBIC = 12; // numbers of a motion without a fifth order

/** Whole rows of texels; the rest of the last row is zero. */
export function packStatics(chunk: StaticChunk): Float32Array<ArrayBuffer> {
  const texels = allocate(chunk.count, STATICS_PER_ROW);
  const { means, quats, logScales, opacities, rgb } = chunk;
  for (let i = 0, at = 0; i < chunk.count; i++, at += 4 * STATIC_TEXELS) {
    for (let k = 0; k < 3; k++) {
      texels[at + k] = means[3 * i + k];
      texels[at + 8 + k] = Math.exp(logScales[3 * i + k]);
      texels[at + 12 + k] = rgb[3 * i + k];
    }
    texels[at + 3] = opacities[i];
    for (let k = 0; k < 4; k++) texels[at + 4 + k] = quats[4 * i + k];
  }
  return texels;
}

/** Whole rows of texels; the rest of the last row is zero. */
export function packDynamics(chunk: DynamicChunk): Float32Array<ArrayBuffer> {
  const texels = allocate(chunk.count, DYNAMICS_PER_ROW);
  const { motion, rotation, logScales, opacities, rgb, timeCenters, timeLogPrecisions } = chunk;
  const width = motion.length / chunk.count;
  for (let i = 0, at = 0; i < chunk.count; i++, at += 4 * DYNAMIC_TEXELS) {
    for (let k = 0; k < 12; k++) texels[at + k] = motion[width * i + k];
    for (let k = 0; k < 8; k++) texels[at + 12 + k] = rotation[8 * i + k];
    for (let k = 0; k < 3; k++) {
      texels[at + 20 + k] = Math.exp(logScales[3 * i + k]);
      texels[at + 24 + k] = rgb[3 * i + k];
    }
    texels[at + 23] = opacities[i];
    texels[at + 27] = timeCenters[i];
    texels[at + 28] = Math.exp(timeLogPrecisions[i]);
    for (let k = CUBIC; k < width; k++) if (motion[width * i + k] !== 0) texels[at + 29] = 1;
  }
  return texels;
}

/** The coefficients above the cubic, whole rows of FIFTH_WIDTH texels; empty if the chunk has none. */
export function packFifth({ motion, count }: DynamicChunk): Float32Array<ArrayBuffer> {
  const width = motion.length / count;
  if (width === CUBIC) return new Float32Array(0);
  const texels = allocate(count, DYNAMICS_PER_ROW, FIFTH_WIDTH);
  for (let i = 0, at = 0; i < count; i++, at += 4 * FIFTH_TEXELS) {
    for (let k = 0; k < 3; k++) {
      texels[at + k] = motion[width * i + CUBIC + k];
      texels[at + 4 + k] = motion[width * i + CUBIC + 3 + k];
    }
  }
  return texels;
}
