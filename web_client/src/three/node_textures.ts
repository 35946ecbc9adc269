/** The data textures of splats and of their order, for nodes of three.js. */

import type { WebGPURenderer } from "three/webgpu";
import { DataTexture, FloatType, RedIntegerFormat, RGBAFormat, UnsignedIntType, Vector2 } from "three/webgpu";
import { FIFTH_WIDTH, STATICS_PER_ROW, TEXTURE_WIDTH } from "../renderer/layout";
import type { SplatSink } from "../renderer/splat_drawer";

/** Rows of a texture that every device with WebGPU supports, and to which three.js keeps. */
const MOST_ROWS = 8192;

/** Texels that are filled row by row. */
class TexelRows {
  texture = floats(new Float32Array(4), 1);
  filled = false;

  constructor(
    readonly what: string,
    readonly width = TEXTURE_WIDTH,
  ) {}

  allocate(rows: number, most: number): void {
    if (rows > most)
      throw new Error(`this device holds ${most} rows of ${this.what} splats, and the scene has ${rows}`);
    this.texture.dispose();
    this.texture = floats(new Float32Array(4 * this.width * Math.max(1, rows)), this.width);
    this.filled = false;
  }

  write(renderer: WebGPURenderer, rows: readonly number[], texels: Float32Array): void {
    this.filled ||= rows.length > 0;
    const row = 4 * this.width;
    for (let i = 0; i < rows.length; ) {
      let end = i + 1;
      while (end < rows.length && rows[end] === rows[end - 1] + 1) end++;
      const part = floats(texels.slice(i * row, end * row), this.width);
      renderer.copyTextureToTexture(part, this.texture, null, new Vector2(0, rows[i]));
      part.dispose();
      i = end;
    }
  }
}

export class NodeTextures implements SplatSink {
  readonly statics = new TexelRows("static");
  readonly dynamics = new TexelRows("dynamic");
  readonly fifth = new TexelRows("dynamic", FIFTH_WIDTH);
  order = ids(1);
  count = 0;
  /** The host's renderer; null until it has drawn. */
  renderer: WebGPURenderer | null = null;
  #dynamicRows = 0;

  get mostRows(): number {
    const context = this.renderer?.getContext();
    return context instanceof WebGL2RenderingContext ? context.getParameter(context.MAX_TEXTURE_SIZE) : MOST_ROWS;
  }

  /** Static splats, dynamic ones, their motions of the fifth order, and the order. */
  get all(): [DataTexture, DataTexture, DataTexture, DataTexture] {
    return [this.statics.texture, this.dynamics.texture, this.fifth.texture, this.order];
  }

  allocate(staticRows: number, dynamicRows: number): void {
    this.statics.allocate(staticRows, this.mostRows);
    this.dynamics.allocate(dynamicRows, this.mostRows);
    this.fifth.allocate(0, this.mostRows);
    this.#dynamicRows = dynamicRows;
  }

  writeStatics(first: number, texels: Float32Array): void {
    const rows = texels.length / (4 * TEXTURE_WIDTH);
    this.#write(
      this.statics,
      Array.from({ length: rows }, (_, i) => first / STATICS_PER_ROW + i),
      texels,
    );
  }

  writeDynamics(rows: readonly number[], texels: Float32Array, fifth: Float32Array): void {
    this.#write(this.dynamics, rows, texels);
    if (fifth.length === 0) return;
    if (!this.fifth.filled) this.fifth.allocate(this.#dynamicRows, this.mostRows);
    this.#write(this.fifth, rows, fifth);
  }

  setOrder(order: Uint32Array, count: number): void {
    const rows = Math.ceil(count / TEXTURE_WIDTH);
    const room = this.order.image.height;
    if (rows > room) {
      this.order.dispose();
      this.order = ids(Math.max(rows, Math.ceil(1.5 * room)));
    }
    (this.order.image.data as Uint32Array).set(order.subarray(0, count));
    this.order.needsUpdate = true;
    this.count = count;
  }

  dispose(): void {
    for (const texture of this.all) texture.dispose();
    this.count = 0;
  }

  #write(target: TexelRows, rows: readonly number[], texels: Float32Array): void {
    if (this.renderer && texels.length > 0) target.write(this.renderer, rows, texels);
  }
}

function floats(data: Float32Array<ArrayBuffer>, width: number): DataTexture {
  const made = new DataTexture(data, width, data.length / (4 * width), RGBAFormat, FloatType);
  made.needsUpdate = true;
  return made;
}

function ids(rows: number): DataTexture {
  const data = new Uint32Array(TEXTURE_WIDTH * rows);
  const made = new DataTexture(data, TEXTURE_WIDTH, rows, RedIntegerFormat, UnsignedIntType);
  made.needsUpdate = true;
  return made;
}
