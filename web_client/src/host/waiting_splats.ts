/**
 * Decoded splats that wait for the host to draw: before that, its context must not be touched, and is unknown at first.
 */

import type { SplatSink } from "../renderer/splat_drawer";

export class WaitingSplats implements SplatSink {
  readonly #mostRows: () => number;
  #writes: ((sink: SplatSink) => void)[] = [];
  #order: Parameters<SplatSink["setOrder"]> | null = null;
  #through: SplatSink | null = null;

  /**
   * Collect splats.
   *
   * @param mostRows texture rows that this device supports.
   */
  constructor(mostRows: () => number) {
    this.#mostRows = mostRows;
  }

  get mostRows(): number {
    return this.#mostRows();
  }

  /** Whether there are none. */
  get empty(): boolean {
    return this.#writes.length === 0 && this.#order === null;
  }

  allocate(...rows: Parameters<SplatSink["allocate"]>): void {
    this.#writes = [];
    this.#write((sink) => sink.allocate(...rows));
  }

  writeStatics(...splats: Parameters<SplatSink["writeStatics"]>): void {
    this.#write((sink) => sink.writeStatics(...splats));
  }

  writeDynamics(...splats: Parameters<SplatSink["writeDynamics"]>): void {
    this.#write((sink) => sink.writeDynamics(...splats));
  }

  /** Called at most once between two frames: each order is requested in a frame. */
  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    this.#order = order;
  }

  /** Pass splats on, those that wait and all later ones as they come; orders go on waiting. */
  pass(sink: SplatSink): void {
    this.#through = sink;
    for (const write of this.#writes.splice(0)) write(sink);
  }

  /** Pass everything on, the order last: it refers to splats that must be there. Returns the order, if there is one. */
  flush(sink: SplatSink): Parameters<SplatSink["setOrder"]> | null {
    for (const write of this.#writes) write(sink);
    this.#writes = [];
    const order = this.#order;
    this.#order = null;
    if (order) sink.setOrder(...order);
    return order;
  }

  #write(write: (sink: SplatSink) => void): void {
    if (this.#through) write(this.#through);
    else this.#writes.push(write);
  }
}
