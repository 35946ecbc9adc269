/** A source whose module is loaded when a scene needs it, so that a page with scenes of other kinds goes without. */

import type { OpenSource, Playhead, SceneSource, SourceEvents } from "./scene_source";

/** @param load the module; what it rejects with is told as the failure `not-loaded`. */
export function openLate(load: () => Promise<OpenSource>): OpenSource {
  return (events, playhead) => new LateSource(load(), events, playhead);
}

/** Until the source has brought a manifest nobody knows a time to seek, and there are no chunks. */
class LateSource implements SceneSource {
  readonly #opened: Promise<SceneSource>;
  #source: SceneSource | null = null;
  #closed = false;

  constructor(
    module: Promise<OpenSource>,
    readonly events: SourceEvents,
    playhead: Playhead,
  ) {
    events.state("connecting");
    this.#opened = module.then((open) => {
      if (this.#closed) throw new DOMException("the source was closed before it could open", "AbortError");
      this.#source = open(events, playhead);
      return this.#source;
    });
    this.#opened.catch((error) => this.#failed(error));
  }

  play(time: number, rate: number): void {
    this.#source?.play(time, rate);
  }

  pause(time: number): void {
    this.#source?.pause(time);
  }

  seek(time: number): void {
    this.#source?.seek(time);
  }

  playheadAt(time: number): void {
    this.#source?.playheadAt(time);
  }

  consumed(bytes: number): void {
    this.#source?.consumed(bytes);
  }

  async fetchAgain(...chunk: Parameters<SceneSource["fetchAgain"]>): Promise<Uint8Array<ArrayBuffer>> {
    return (await this.#opened).fetchAgain(...chunk);
  }

  wake(): void {
    this.#source?.wake();
  }

  close(): void {
    this.#closed = true;
    if (this.#source) this.#source.close();
    else this.events.state("closed");
  }

  #failed(error: unknown): void {
    if (this.#closed) return;
    this.close();
    this.events.failed("not-loaded", error instanceof Error ? error.message : String(error));
  }
}
