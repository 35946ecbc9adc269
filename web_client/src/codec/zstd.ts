/** One zstd frame at a time, through WebAssembly. */

import { ZSTDDecoder } from "zstddec";

const decoder = new ZSTDDecoder();
const ready = decoder.init();

/** Resolves when `decompress` may be called. */
export function zstdReady(): Promise<void> {
  return ready;
}

/** Returns the content of a frame, or undefined unless it is one frame whose header states exactly `length` bytes. */
export function decompress(frame: Uint8Array, length: number): Uint8Array | undefined {
  if (contentSize(frame) !== length) return undefined;
  const raw = decoder.decode(frame, length);
  return raw.length === length ? raw : undefined;
}

/** Reads the content size from a frame header (RFC 8878, section 3.1.1); undefined if it is absent or damaged. */
function contentSize(frame: Uint8Array): number | undefined {
  const view = new DataView(frame.buffer, frame.byteOffset, frame.byteLength);
  if (frame.length < 5 || view.getUint32(0, true) !== 0xfd2fb528) return undefined;
  const descriptor = frame[4];
  const single = (descriptor >> 5) & 1;
  const dictionary = [0, 1, 2, 4][descriptor & 3];
  const at = 5 + (single ? 0 : 1) + dictionary;
  const size = [single, 2, 4, 8][descriptor >> 6];
  if (size === 0 || frame.length < at + size) return undefined;
  if (size === 1) return frame[at];
  if (size === 2) return view.getUint16(at, true) + 256;
  return size === 4 ? view.getUint32(at, true) : Number(view.getBigUint64(at, true));
}
