/** CRC-32 as in zlib and PNG (polynomial 0xedb88320, reflected). */

/** [4][256] remainders of a byte followed by 0 to 3 zero bytes, so that four bytes are taken at once. */
const TABLES = [new Uint32Array(256)];
for (let byte = 0; byte < 256; byte++) {
  let remainder = byte;
  for (let bit = 0; bit < 8; bit++) remainder = remainder & 1 ? (remainder >>> 1) ^ 0xedb88320 : remainder >>> 1;
  TABLES[0][byte] = remainder;
}
for (let zeros = 1; zeros < 4; zeros++)
  TABLES.push(TABLES[zeros - 1].map((remainder) => (remainder >>> 8) ^ TABLES[0][remainder & 255]));

export function crc32(bytes: Uint8Array): number {
  const [none, one, two, three] = TABLES;
  let crc = 0xffffffff;
  let i = 0;
  for (; i + 4 <= bytes.length; i += 4) {
    crc ^= bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16) | (bytes[i + 3] << 24);
    crc = three[crc & 255] ^ two[(crc >>> 8) & 255] ^ one[(crc >>> 16) & 255] ^ none[crc >>> 24];
  }
  for (; i < bytes.length; i++) crc = (crc >>> 8) ^ none[(crc ^ bytes[i]) & 255];
  return (crc ^ 0xffffffff) >>> 0;
}
