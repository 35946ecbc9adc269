/**
 * The source for a scene in a folder of any web server (docs/static.md): fetches the manifest, and then chunks in order
 * of need, a few at a time.
 */

import { ManifestError } from "../codec/errors";
import { parseManifest } from "../codec/manifest";
import type { ChunkEntry } from "../codec/types";
import { ChunkOrder } from "./chunk_order";
import { download, retryDelay, StatusError } from "./download";
import { GZIP, type Playhead, type SceneManifest, type SceneSource, type SourceEvents } from "./scene_source";
import { Throughput } from "./throughput";

/** Parallel downloads: enough to fill a long line, and few enough to turn around quickly after a seek. */
const PARALLEL = 4;
/** Bytes of complete chunks waiting for the decoder before downloads pause. */
const UNDECODED = 16 << 20;
/** Wrong answers in place of a chunk before the scene is shown without it. */
const MOST_REFUSALS = 3;

export class HttpSource implements SceneSource {
  readonly #abort = new AbortController();
  readonly #fetching = new Map<string, AbortController>();
  readonly #settled = new Set<string>(); // chunks that were received or given up
  readonly #refusals = new Map<string, number>();
  readonly #throughput = new Throughput();
  #url: string; // index or manifest
  #scene: SceneManifest | null = null;
  #order: ChunkOrder | null = null; // null until the manifest has arrived
  #playhead: Playhead;
  #undecoded = 0; // bytes
  #failures = 0; // failures since the last success
  #retry: ReturnType<typeof setTimeout> | undefined; // set while nothing is requested

  /**
   * Open a scene.
   *
   * @param url of the index or manifest.
   * @param hidden whether the page is hidden: then nothing more is fetched until `wake`.
   * @param query for every address, such as `?link=…`, if the server requires one.
   */
  constructor(
    url: string,
    readonly events: SourceEvents,
    playhead: Playhead,
    readonly hidden: () => boolean = () => document.hidden,
    readonly query = "",
  ) {
    this.#url = url + query;
    this.#playhead = playhead;
    events.state("connecting");
    void this.#fetchManifest();
  }

  play(time: number, rate: number): void {
    this.#playhead = { time, rate };
    this.#fetchMore();
  }

  pause(time: number): void {
    this.#playhead = { time, rate: 0 };
    this.#fetchMore();
  }

  /** Downloads that are not needed soon make room for needed ones. */
  seek(time: number): void {
    this.#playhead = { ...this.#playhead, time };
    const needed = new Set(this.#next().map((chunk) => chunk.id));
    for (const [id, abort] of this.#fetching) if (!needed.has(id)) abort.abort();
    this.#fetchMore();
  }

  playheadAt(time: number): void {
    this.#playhead = { ...this.#playhead, time };
  }

  consumed(bytes: number): void {
    this.#undecoded -= bytes;
    this.#fetchMore();
  }

  async fetchAgain(
    id: string,
    signal: AbortSignal,
    cache: "reload" | "default" = "reload",
  ): Promise<Uint8Array<ArrayBuffer>> {
    return (await download(this.#chunkUrl(id), signal, cache, this.#order?.chunks.get(id)?.chunk.bytes)).bytes;
  }

  wake(): void {
    const waiting = this.#retry !== undefined;
    clearTimeout(this.#retry);
    this.#retry = undefined;
    if (this.#order) this.#fetchMore();
    else if (waiting) void this.#fetchManifest();
  }

  close(): void {
    if (this.#abort.signal.aborted) return;
    this.#abort.abort();
    clearTimeout(this.#retry);
    for (const abort of this.#fetching.values()) abort.abort();
    this.events.state("closed");
  }

  async #fetchManifest(): Promise<void> {
    const { signal } = this.#abort;
    try {
      const { url, bytes } = await download(this.#url, signal, "no-cache");
      const scene = await readManifest(bytes);
      if (signal.aborted) return;
      this.#url = url;
      this.#failures = 0;
      this.events.state("open");
      this.become(scene);
      if (!scene.manifest.live) return;
      import("./manifest_polling").then(
        ({ followManifest }) => followManifest(this, url, scene, signal),
        ({ message }) => this.events.failed("not-loaded", message),
      );
    } catch (error) {
      if (signal.aborted) return;
      const missing = error instanceof StatusError && (error.missing || error.status === 403);
      if (this.#locked(error)) return;
      if (missing || error instanceof ManifestError || error instanceof SyntaxError) {
        this.close();
        this.events.failed(missing ? "no-scene" : "unreadable", error.message);
      } else {
        this.#retryLater(() => void this.#fetchManifest());
      }
    }
  }

  /** Fetch the chunks of this manifest from now on. */
  become(scene: SceneManifest): void {
    const event = this.#scene ? "grown" : "manifest";
    this.#scene = scene;
    this.events[event](scene.manifest);
    this.#order = new ChunkOrder(scene.manifest);
    this.#fetchMore();
  }

  #fetchMore(): void {
    if (this.#retry !== undefined || this.#undecoded > UNDECODED || this.hidden()) return;
    for (const chunk of this.#next()) {
      if (this.#fetching.size >= PARALLEL) return;
      if (!this.#fetching.has(chunk.id)) void this.#fetchChunk(chunk);
    }
  }

  /**
   * The chunks to download now, in order of need: the chunks of the first picture have the line for themselves, later
   * ones share it.
   */
  #next(): ChunkEntry[] {
    const order = this.#order;
    if (!order || this.#abort.signal.aborted) return [];
    const picture = order.picture(this.#playhead.time ?? order.manifest.start);
    const rate = this.#throughput.rate(performance.now());
    const chunks: ChunkEntry[] = [];
    for (const chunk of order.missing(this.#playhead, rate, (id) => this.#settled.has(id))) {
      if (chunks.length === PARALLEL || (picture.includes(chunks[0]) && !picture.includes(chunk))) break;
      chunks.push(chunk);
    }
    return chunks;
  }

  async #fetchChunk(chunk: ChunkEntry): Promise<void> {
    const { id } = chunk;
    const abort = new AbortController();
    this.#fetching.set(id, abort);
    try {
      const cache = this.#refusals.has(id) ? "reload" : "default"; // the cached copy may be the wrong one
      const { bytes } = await download(this.#chunkUrl(id), abort.signal, cache, chunk.bytes);
      if (abort.signal.aborted) return;
      this.#throughput.count(bytes.length, performance.now());
      const page = await this.#scene?.add?.(id, bytes);
      if (this.#failures > 0) this.events.state("open");
      this.#failures = 0;
      if (page) {
        this.become(this.#scene as SceneManifest); // the manifest no longer lists it
        return;
      }
      this.#settled.add(id);
      this.#undecoded += bytes.length;
      this.events.progress(bytes.length);
      this.events.chunk(id, bytes);
    } catch (error) {
      if (!abort.signal.aborted) this.#failed(chunk, error);
    } finally {
      if (this.#fetching.get(id) === abort) this.#fetching.delete(id);
      this.#fetchMore();
    }
  }

  /** End if the server requires a key, or another key than the given one. */
  #locked(error: unknown): boolean {
    if (!(error instanceof StatusError && error.status === 401)) return false;
    this.close();
    this.events.failed(this.#scene ? "access-ended" : "no-access", error.message);
    return true;
  }

  #failed({ id }: ChunkEntry, error: unknown): void {
    if (this.#locked(error)) return;
    const missing = error instanceof StatusError && error.missing;
    const refused = error instanceof StatusError || error instanceof ManifestError; // otherwise there was no answer
    const refusals = (this.#refusals.get(id) ?? 0) + 1;
    if (refused) this.#refusals.set(id, refusals);
    if (missing || (refused && refusals >= MOST_REFUSALS)) {
      this.#settled.add(id);
      this.events.missing(id);
    } else {
      this.#retryLater(() => this.#fetchMore());
    }
  }

  #retryLater(again: () => void): void {
    if (this.#retry !== undefined) return;
    this.events.state("retrying");
    this.#retry = setTimeout(
      () => {
        this.#retry = undefined;
        again();
      },
      retryDelay(this.#failures++),
    );
  }

  #chunkUrl(id: string): string {
    return new URL(`chunks/${id}${this.query}`, this.#url).href;
  }
}

/**
 * Read a manifest, at once, or an index, with a module of its own.
 *
 * @throws SyntaxError or ManifestError, or rejects with one or with another error, if it cannot be read
 */
function readManifest(bytes: Uint8Array<ArrayBuffer>): SceneManifest | Promise<SceneManifest> {
  if (bytes[0] === GZIP) return import("./paged_manifest").then(({ readIndex }) => readIndex(bytes));
  return { manifest: parseManifest(JSON.parse(new TextDecoder().decode(bytes))) };
}
