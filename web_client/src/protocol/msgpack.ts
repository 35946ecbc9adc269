/** The part of MessagePack that the protocol uses; whole numbers only up to JavaScript's exact range. */

export type Packable =
  | null
  | boolean
  | number
  | string
  | Uint8Array
  | readonly Packable[]
  | { readonly [name: string]: Packable | undefined };

/** Pack a value; undefined fields are left out. */
export function pack(value: Packable): Uint8Array<ArrayBuffer> {
  const bytes: number[] = [];
  write(value, bytes);
  return Uint8Array.from(bytes);
}

/**
 * Unpack the one value in the bytes; byte strings are views into them, extensions become undefined.
 *
 * @throws RangeError if the bytes are something else, TypeError if a text is not UTF-8
 */
export function unpack(bytes: Uint8Array): unknown {
  const reader = new Reader(bytes);
  const value = reader.value();
  if (reader.at !== bytes.length) throw new RangeError(`${bytes.length - reader.at} bytes after the value`);
  return value;
}

function write(value: Packable, out: number[]): void {
  if (value === null) out.push(0xc0);
  else if (typeof value === "boolean") out.push(value ? 0xc3 : 0xc2);
  else if (typeof value === "number") writeNumber(value, out);
  else if (typeof value === "string") {
    const text = new TextEncoder().encode(value);
    if (text.length < 32) out.push(0xa0 | text.length);
    else writeHead(text.length, [0xd9, 0xda, 0xdb], out);
    for (const byte of text) out.push(byte);
  } else if (value instanceof Uint8Array) {
    writeHead(value.length, [0xc4, 0xc5, 0xc6], out);
    for (const byte of value) out.push(byte);
  } else if (isList(value)) {
    if (value.length < 16) out.push(0x90 | value.length);
    else writeHead(value.length, [null, 0xdc, 0xdd], out);
    for (const item of value) write(item, out);
  } else {
    const fields = Object.entries(value).filter(([, field]) => field !== undefined);
    if (fields.length < 16) out.push(0x80 | fields.length);
    else writeHead(fields.length, [null, 0xde, 0xdf], out);
    for (const [name, field] of fields) {
      write(name, out);
      write(field as Packable, out);
    }
  }
}

const isList = (value: Packable): value is readonly Packable[] => Array.isArray(value);

function writeNumber(value: number, out: number[]): void {
  const whole = Number.isSafeInteger(value);
  if (whole && value >= -32 && value < 0x80) out.push(value & 0xff);
  else if (whole && value >= 0 && value < 2 ** 32) writeHead(value, [0xcc, 0xcd, 0xce], out);
  else {
    const view = new DataView(new ArrayBuffer(8));
    if (whole) view.setBigInt64(0, BigInt(value));
    else view.setFloat64(0, value);
    out.push(whole ? (value < 0 ? 0xd3 : 0xcf) : 0xcb, ...new Uint8Array(view.buffer));
  }
}

/** Write a number below 2^32 in one, two or four bytes, behind the type for that length. */
function writeHead(value: number, [one, two, four]: readonly [number | null, number, number], out: number[]): void {
  if (one !== null && value < 0x100) out.push(one, value);
  else if (value < 0x10000) out.push(two, value >> 8, value & 255);
  else out.push(four, value >>> 24, (value >> 16) & 255, (value >> 8) & 255, value & 255);
}

class Reader {
  at = 0;
  readonly #view: DataView;

  constructor(readonly bytes: Uint8Array) {
    this.#view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  }

  value(): unknown {
    const type = this.#whole(1);
    if (type < 0x80) return type;
    if (type < 0x90) return this.#map(type & 15);
    if (type < 0xa0) return this.#list(type & 15);
    if (type < 0xc0) return this.#text(type & 31);
    if (type >= 0xe0) return type - 0x100;
    const size = 1 << (type & 3); // bytes of the following number; types come in fours
    switch (type) {
      case 0xc0:
        return null;
      case 0xc2:
      case 0xc3:
        return type === 0xc3;
      case 0xc4:
      case 0xc5:
      case 0xc6:
        return this.#take(this.#whole(size));
      case 0xc7:
      case 0xc8:
      case 0xc9:
        this.#take(this.#whole(1 << (type - 0xc7)) + 1); // an extension, with its type
        return undefined;
      case 0xca:
        return this.#view.getFloat32(this.#skip(4));
      case 0xcb:
        return this.#view.getFloat64(this.#skip(8));
      case 0xcc:
      case 0xcd:
      case 0xce:
      case 0xcf:
        return this.#whole(size);
      case 0xd0:
        return this.#view.getInt8(this.#skip(1));
      case 0xd1:
        return this.#view.getInt16(this.#skip(2));
      case 0xd2:
        return this.#view.getInt32(this.#skip(4));
      case 0xd3:
        return Number(this.#view.getBigInt64(this.#skip(8)));
      case 0xd4:
      case 0xd5:
      case 0xd6:
      case 0xd7:
      case 0xd8:
        this.#take((1 << (type - 0xd4)) + 1);
        return undefined;
      case 0xd9:
      case 0xda:
      case 0xdb:
        return this.#text(this.#whole(1 << (type - 0xd9)));
      case 0xdc:
      case 0xdd:
        return this.#list(this.#whole(2 << (type - 0xdc)));
      case 0xde:
      case 0xdf:
        return this.#map(this.#whole(2 << (type - 0xde)));
    }
    throw new RangeError(`0x${type.toString(16)} is no type`);
  }

  /** An unsigned number of `size` bytes. */
  #whole(size: number): number {
    let value = 0;
    for (const byte of this.#take(size)) value = value * 256 + byte;
    return value;
  }

  #text(length: number): string {
    return new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(this.#take(length));
  }

  #list(length: number): unknown[] {
    const items: unknown[] = [];
    for (let i = 0; i < length; i++) items.push(this.value());
    return items;
  }

  #map(length: number): Record<string, unknown> {
    const fields: [string, unknown][] = [];
    for (let i = 0; i < length; i++) {
      const name = this.value();
      if (typeof name !== "string") throw new RangeError(`${String(name)} is no name of a field`);
      fields.push([name, this.value()]);
    }
    return Object.fromEntries(fields);
  }

  #take(length: number): Uint8Array {
    const from = this.#skip(length);
    return this.bytes.subarray(from, this.at);
  }

  #skip(length: number): number {
    if (this.at + length > this.bytes.length) throw new RangeError(`cut off at byte ${this.bytes.length}`);
    const from = this.at;
    this.at += length;
    return from;
  }
}
