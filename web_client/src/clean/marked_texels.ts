/** Marked splats in the player's textures: selected ones in a colour of their own, hidden and deleted ones invisible. */

import type { SceneCanvas } from "../player/scene_canvas";
import { DYNAMIC_TEXELS, placeStatics, STATIC_TEXELS, type StaticPlacement } from "../renderer/layout";
import type { ChunkLoader } from "./chunk_loader";
import type { ChunkSplats } from "./seen_splats";
import { DELETED, HIDDEN, SELECTED, type SplatMarks } from "./splat_marks";

/** Colour of selected splats, sRGB, and its share. */
const TINT = [1, 0.16, 0.5] as const;
const SHARE = 0.75;

/** A chunk's texels with the marks in them. */
export function markedTexels({ kind, texels, count }: ChunkSplats, marks: Uint8Array): Float32Array {
  const marked = texels.slice();
  const [size, opacity, rgb] = kind === "static" ? [4 * STATIC_TEXELS, 3, 12] : [4 * DYNAMIC_TEXELS, 23, 24];
  for (let i = 0; i < count; i++) {
    if (marks[i] & (HIDDEN | DELETED)) marked[size * i + opacity] = 0;
    else if (marks[i] & SELECTED) {
      for (let k = 0; k < 3; k++) {
        const at = size * i + rgb + k;
        marked[at] += SHARE * (TINT[k] - marked[at]);
      }
    }
  }
  return marked;
}

export class MarkedTextures {
  readonly #statics: StaticPlacement;
  /** Chunks that are being written or are to be written once more. */
  readonly #late = new Set<string>();
  #version = -1; // version of the player's chunks at the last write

  constructor(
    readonly scene: SceneCanvas,
    readonly loader: ChunkLoader,
    readonly marks: SplatMarks,
    readonly failed: (error: Error) => void,
  ) {
    this.#statics = placeStatics(loader.manifest);
  }

  /** Write the marks of chunks again, and of all after the player has decoded any: it may have written over them. */
  update(ids: readonly string[] = []): void {
    const { chunks, contextLost } = this.scene.stats;
    if (contextLost) return;
    const again = chunks !== this.#version ? this.marks.ids : ids;
    this.#version = chunks;
    for (const id of again) void this.#write(id);
  }

  /** Leave all splats as they are in the scene. */
  clear(): void {
    for (const id of this.marks.ids) void this.#write(id, true);
  }

  async #write(id: string, plain = false): Promise<void> {
    if (this.#late.has(id) && !plain) return; // the write under way takes the latest marks
    this.#late.add(id);
    try {
      const chunk = await this.loader.load(id);
      this.#late.delete(id);
      const { renderer, playback } = this.scene;
      const state = playback?.buffer.states.get(id);
      if (state?.at !== "drawn" || renderer.lost) return; // it is written once it is there
      const marks = this.marks.of(id);
      const texels = marks && !plain ? markedTexels(chunk, marks) : chunk.texels;
      const first = this.#statics.first.get(id);
      if (first !== undefined) renderer.splats.writeStatics(first, texels);
      else renderer.splats.writeDynamics(state.rows, texels, chunk.fifth);
      this.scene.quality = this.scene.quality; // draws once more
    } catch (error) {
      this.#late.delete(id);
      this.failed(error as Error);
    }
  }
}
