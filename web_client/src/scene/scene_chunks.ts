/**
 * The path of a scene's chunks: from the source through the decoder into the sink's textures, and out of them again.
 */

import { chunksBetween } from "../codec/manifest_chunks";
import type { Manifest } from "../codec/types";
import { placeStatics } from "../renderer/layout";
import type { SplatSink } from "../renderer/splat_drawer";
import type { SceneSource } from "../source/scene_source";
import type { DecodedSplats } from "../worker/messages";
import type { SceneWorker } from "../worker/scene_worker";
import type { SceneBuffer } from "./buffer";
import { ChunkIntake } from "./chunk_intake";
import { defaultBudget, dynamicRows } from "./memory_budget";
import type { Moment } from "./moment";
import { Residency } from "./residency";

export interface ChunkParts {
  readonly worker: Pick<SceneWorker, "decode" | "evict" | "repack">;
  readonly sink: SplatSink;
  readonly source: () => Pick<SceneSource, "consumed" | "fetchAgain" | "close">;
  /** A chunk has arrived, changed or gone. */
  readonly changed: () => void;
}

export class SceneChunks {
  readonly #parts: ChunkParts;
  readonly #intake: ChunkIntake;
  #buffer: SceneBuffer | null = null; // null until the manifest has arrived
  #residency: Residency | null = null;
  #version = 0;
  #restoring = false;

  constructor(parts: ChunkParts) {
    this.#parts = parts;
    this.#intake = new ChunkIntake(
      {
        decode: (id, bytes) => this.#decode(id, bytes),
        consumed: (bytes) => parts.source().consumed(bytes),
        lost: (id, message) => {
          // biome-ignore lint/suspicious/noConsole: the page has plain words for it; this is the cause
          console.warn(message);
          this.#residency?.lost(id);
          this.missing(id);
        },
      },
      (id, signal) => parts.source().fetchAgain(id, signal),
    );
  }

  /** Number of chunks decoded by the worker, and of refills of the sink. */
  get version(): number {
    return this.#version;
  }

  /** Whether the sink is being refilled. */
  get restoring(): boolean {
    return this.#restoring;
  }

  /**
   * Make room for a scene within a memory budget, bytes; the default is for the kind of device. `buffer` is kept up to
   * date.
   *
   * @throws Error if the device cannot hold the scene's statics.
   */
  begin(manifest: Manifest, buffer: SceneBuffer, budget = defaultBudget()): void {
    const { sink, worker } = this.#parts;
    const staticRows = placeStatics(manifest).rows;
    const rows = dynamicRows(manifest, staticRows, budget, sink.mostRows);
    sink.allocate(staticRows, rows);
    this.#buffer = buffer;
    this.#residency = new Residency(
      manifest,
      buffer.states,
      rows,
      {
        decode: (id, bytes, into) => worker.decode(id, bytes, into),
        evicted: (id) => worker.evict(id),
        dropped: (id) => this.#intake.done(id),
        changed: () => this.#parts.changed(),
      },
      (id, signal) => this.#parts.source().fetchAgain(id, signal, "default"),
    );
  }

  /** The manifest has become a later version. */
  grow(): void {
    this.#buffer?.grow();
    this.#residency?.grow();
    this.#close();
  }

  /** A complete chunk has arrived from the source. */
  arrived(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    this.#intake.arrived(id, bytes);
  }

  /** Continue without a chunk. */
  missing(id: string): void {
    this.#buffer?.states.lose(id);
    this.#parts.changed();
  }

  /** The worker has decoded a chunk. */
  decoded(splats: DecodedSplats): void {
    const { id } = splats;
    this.#write(splats);
    this.#version++;
    this.#intake.done(id);
    this.#residency?.decoded(id);
    this.#close();
    this.#parts.changed();
  }

  /** The worker cannot decode a chunk; `message` is the reason. */
  damaged(id: string, message: string): void {
    void this.#intake.damaged(id, message);
  }

  /** Keep the chunks for a playhead at `time`, seconds, and for the orders of these moments in memory. */
  reside(time: number, moments: () => readonly Moment[]): void {
    const slices = this.#buffer?.manifest.slices;
    if (!slices) return;
    const shown = () => new Set(moments().flatMap(({ from, until }) => chunksBetween(slices, from, until)));
    this.#residency?.update(time, shown);
  }

  /** Refill the sink, which has lost everything. */
  restore(): void {
    this.#restoring = true;
    this.#parts.worker.repack();
  }

  /** A chunk's splats are packed again. */
  packed(splats: DecodedSplats): void {
    this.#write(splats);
  }

  /** All chunks are packed again. */
  repacked(): void {
    this.#restoring = false;
    this.#version++; // forces a new picture
    this.#parts.changed();
  }

  /** Stop fetching and reporting. */
  dispose(): void {
    this.#intake.dispose();
    this.#residency?.dispose();
  }

  /** Close the source of a complete scene; evicted chunks are fetched by their ids. */
  #close(): void {
    if (this.#buffer?.complete) this.#parts.source().close();
  }

  /** Decode a chunk; a dynamic one once there is room. */
  #decode(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    if (this.#residency?.concerns(id)) this.#residency.offer(id, bytes);
    else this.#parts.worker.decode(id, bytes);
  }

  #write({ kind, first, rows, texels, fifth }: DecodedSplats): void {
    const { sink } = this.#parts;
    if (kind === "static") sink.writeStatics(first, texels);
    else sink.writeDynamics(rows, texels, fifth);
  }
}
