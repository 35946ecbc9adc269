/** CRC-32 as in zlib and PNG (polynomial 0xedb88320, reflected). */

/** [8][256] remainders of a byte followed by 0 to 7 zero bytes: eight bytes are processed at once. */
const TABLES = [new Int32Array(256)];
for (let byte = 0; byte < 256; byte++) {
  let remainder = byte;
  for (let bit = 0; bit < 8; bit++) remainder = remainder & 1 ? (remainder >>> 1) ^ 0xedb88320 : remainder >>> 1;
  TABLES[0][byte] = remainder;
}
for (let zeros = 1; zeros < 8; zeros++)
  TABLES.push(TABLES[zeros - 1].map((remainder) => (remainder >>> 8) ^ TABLES[0][remainder & 255]));

export function crc32(bytes: Uint8Array): number {
  const [t0, t1, t2, t3, t4, t5, t6, t7] = TABLES;
  const aligned = bytes.byteOffset % 4 === 0 ? bytes : bytes.slice();
  // Words in memory order: browsers run on little-endian processors only.
  const words = new Int32Array(aligned.buffer, aligned.byteOffset, 2 * (bytes.length >> 3));
  let crc = -1;
  for (let i = 0; i < words.length; i += 2) {
    const low = crc ^ words[i];
    const high = words[i + 1];
    crc =
      t7[low & 255] ^
      t6[(low >>> 8) & 255] ^
      t5[(low >>> 16) & 255] ^
      t4[low >>> 24] ^
      t3[high & 255] ^
      t2[(high >>> 8) & 255] ^
      t1[(high >>> 16) & 255] ^
      t0[high >>> 24];
  }
  for (let i = 4 * words.length; i < bytes.length; i++) crc = (crc >>> 8) ^ t0[(crc ^ bytes[i]) & 255];
  return ~crc >>> 0;
}
