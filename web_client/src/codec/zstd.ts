/** The zstd frames of an attribute, decompressed together through WebAssembly. */

const MAGIC = 0xfd2fb528;
const LAST = 1; // flag in a block's header
const RLE = 1; // types of blocks
const RESERVED = 3;

/** The exports of zstd.wasm (`web_client/zstd/decoder.c`). Addresses and sizes are in bytes of its memory. */
interface Zstd {
  readonly memory: WebAssembly.Memory;
  /** Start of the memory that is free for the caller. */
  readonly __heap_base: WebAssembly.Global<"i32">;
  /** Returns the number of bytes written, or a negative number for an error. */
  decompress(to: number, capacity: number, from: number, size: number): number;
}

const PAGE = 65536; // bytes, the unit of growth

let zstd: Zstd | undefined;
let nowReady: () => void;
const ready = new Promise<void>((resolve) => {
  nowReady = resolve;
});

/** Provide the compiled decompressor; required before any decompression. */
export async function provideZstd(module: WebAssembly.Module): Promise<void> {
  const { exports } = await WebAssembly.instantiate(module);
  zstd = exports as unknown as Zstd;
  nowReady();
}

/** Resolves when `decompress` may be called. */
export function zstdReady(): Promise<void> {
  return ready;
}

/**
 * Decompress frames into one array. Returns the contents in order, or the index of the first frame that is not a single
 * frame with a header that states exactly `length` bytes, and those bytes. The frames must be adjacent in one buffer: a
 * call costs about as much as the decompression of a thousand bytes.
 */
export function decompress(frames: readonly Uint8Array[], length: number): Uint8Array | number {
  // Every frame ends where the next one begins, so zstd, which reads them as one input, finds the same frames.
  let bytes = 0;
  for (let i = 0; i < frames.length; i++) {
    if (!isWhole(frames[i], length)) return firstDamaged(frames.slice(0, i), length) ?? i;
    bytes += frames[i].length;
  }
  const raw = contentOf(new Uint8Array(frames[0].buffer, frames[0].byteOffset, bytes), frames.length * length);
  return raw ?? firstDamaged(frames, length) ?? 0;
}

/** Index of the first of whole frames that zstd refuses. */
function firstDamaged(frames: readonly Uint8Array[], length: number): number | undefined {
  const place = frames.findIndex((frame) => !contentOf(frame, length));
  return place < 0 ? undefined : place;
}

function contentOf(frames: Uint8Array, length: number): Uint8Array | undefined {
  if (!zstd) throw new Error("the decompressor has not been provided yet");
  const { memory } = zstd;
  const to = zstd.__heap_base.value;
  const from = to + length;
  const lacking = from + frames.length - memory.buffer.byteLength;
  if (lacking > 0) memory.grow(Math.ceil(lacking / PAGE));
  const bytes = new Uint8Array(memory.buffer);
  bytes.set(frames, from);
  return zstd.decompress(to, length, from, frames.length) === length ? bytes.slice(to, from) : undefined;
}

/** Whether the bytes are exactly one frame (RFC 8878, section 3.1.1) that states `length`; the content is not read. */
function isWhole(frame: Uint8Array, length: number): boolean {
  const size = frame.length;
  if (size < 5 || (frame[0] | (frame[1] << 8) | (frame[2] << 16) | (frame[3] << 24)) >>> 0 !== MAGIC) return false;
  const descriptor = frame[4];
  const single = (descriptor >> 5) & 1;
  let at = 5 + (single ? 0 : 1) + [0, 1, 2, 4][descriptor & 3];
  const width = [single, 2, 4, 8][descriptor >> 6]; // bytes of the content size
  if (width === 0 || size < at + width) return false;
  let stated = width === 2 ? 256 : 0;
  for (let i = 0; i < width; i++) stated += frame[at + i] * 2 ** (8 * i);
  if (stated !== length) return false;
  at += width;
  let last = false;
  while (!last) {
    if (size < at + 3) return false;
    const header = frame[at] | (frame[at + 1] << 8) | (frame[at + 2] << 16);
    const type = (header >> 1) & 3;
    if (type === RESERVED) return false;
    last = (header & LAST) !== 0;
    at += 3 + (type === RLE ? 1 : header >> 3);
  }
  return at + (descriptor & 4 ? 4 : 0) === size; // 4 bytes of a checksum are optional
}
