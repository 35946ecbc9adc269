/** Splats that have been decoded, until the host draws: only then its context may be touched, and is known at all. */

import type { SplatSink } from "../renderer/splat_drawer";

export class WaitingSplats implements SplatSink {
  readonly #mostRows: () => number;
  #writes: ((sink: SplatSink) => void)[] = [];
  #order: Parameters<SplatSink["setOrder"]> | null = null;

  /** @param mostRows tells how many rows a texture can have on this device. */
  constructor(mostRows: () => number) {
    this.#mostRows = mostRows;
  }

  get mostRows(): number {
    return this.#mostRows();
  }

  /** Whether nothing waits. */
  get empty(): boolean {
    return this.#writes.length === 0 && this.#order === null;
  }

  allocate(...rows: Parameters<SplatSink["allocate"]>): void {
    this.#writes = [(sink) => sink.allocate(...rows)];
  }

  writeStatics(...splats: Parameters<SplatSink["writeStatics"]>): void {
    this.#writes.push((sink) => sink.writeStatics(...splats));
  }

  writeDynamics(...splats: Parameters<SplatSink["writeDynamics"]>): void {
    this.#writes.push((sink) => sink.writeDynamics(...splats));
  }

  /** Comes once between two frames at most: an order is asked for in a frame. */
  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    this.#order = order;
  }

  /** Hand everything over, the order last: it names splats that must be there. Returns the order, if there is one. */
  flush(sink: SplatSink): Parameters<SplatSink["setOrder"]> | null {
    for (const write of this.#writes) write(sink);
    this.#writes = [];
    const order = this.#order;
    this.#order = null;
    if (order) sink.setOrder(...order);
    return order;
  }
}
