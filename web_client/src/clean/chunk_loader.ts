/** The decoded splats of a playing scene, fetched once more: the player keeps none outside of its textures. */

import { chunksOf, sliceAt } from "../codec/manifest_chunks";
import type { Manifest } from "../codec/types";
import type { SceneCanvas } from "../player/scene_canvas";
import type { DecodedSplats } from "../worker/messages";
import { SceneWorker } from "../worker/scene_worker";
import type { ChunkSplats } from "./seen_splats";

interface Waiting {
  resolve(splats: DecodedSplats): void;
  reject(error: Error): void;
}

export class ChunkLoader {
  readonly #worker: SceneWorker;
  readonly #waiting = new Map<string, Waiting>();
  readonly #chunks = new Map<string, Promise<ChunkSplats>>();
  #sizes: ReadonlyMap<string, number> = new Map();
  readonly #gone = new AbortController();

  constructor(
    readonly manifest: Manifest,
    readonly scene: SceneCanvas,
  ) {
    this.#worker = new SceneWorker({
      decoded: (splats) => this.#answer(splats.id, ({ resolve }) => resolve(splats)),
      damaged: (id, message) => this.#answer(id, ({ reject }) => reject(new Error(message))),
      stopped: (cause) => {
        for (const id of [...this.#waiting.keys()]) this.#answer(id, ({ reject }) => reject(new Error(cause)));
      },
      packed: () => {},
      repacked: () => {},
      ordered: () => {},
    });
    this.#worker.begin(manifest);
  }

  /** Number of a chunk's splats; 0 for an unknown chunk. */
  sizeOf(id: string): number {
    if (!this.#sizes.has(id)) {
      const entries = [...this.manifest.static, ...this.manifest.slices.flatMap(({ chunks }) => chunks)];
      this.#sizes = new Map(entries.map((entry) => [entry.id, entry.splats])); // the scene may have grown
    }
    return this.#sizes.get(id) ?? 0;
  }

  /** The chunks on the screen at a time, seconds; others are forgotten unless `kept` says otherwise. */
  async shownAt(time: number, kept: (id: string) => boolean): Promise<ChunkSplats[]> {
    const { slices } = this.manifest;
    const slice = slices[sliceAt(slices, time)];
    const ids = [...this.manifest.static.map(({ id }) => id), ...(slice ? chunksOf(slice) : [])];
    for (const id of this.#chunks.keys()) if (!ids.includes(id) && !kept(id)) this.#chunks.delete(id);
    const states = this.scene.playback?.buffer.states;
    return Promise.all(ids.filter((id) => states?.get(id)?.at === "drawn").map((id) => this.load(id)));
  }

  /** A chunk, fetched if need be; rejects with one line for people. */
  load(id: string): Promise<ChunkSplats> {
    const there = this.#chunks.get(id);
    if (there) return there;
    const coming = this.#load(id);
    this.#chunks.set(id, coming);
    coming.catch(() => this.#chunks.delete(id)); // the next use tries again
    return coming;
  }

  dispose(): void {
    this.#gone.abort();
    this.#worker.dispose();
    this.#chunks.clear();
  }

  async #load(id: string): Promise<ChunkSplats> {
    const bytes = await this.scene.source.fetchAgain(id, this.#gone.signal, "default");
    const { kind, texels, fifth } = await new Promise<DecodedSplats>((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.decode(id, bytes);
    });
    this.#worker.evict(id);
    return { id, kind, texels, fifth, count: this.sizeOf(id) };
  }

  #answer(id: string, how: (waiting: Waiting) => void): void {
    const waiting = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (waiting) how(waiting);
  }
}
