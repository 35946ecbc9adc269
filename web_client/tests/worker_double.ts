/** Stands in for the browser's Worker: notes what the page says, and answers as a test tells it. */

import { readFileSync } from "node:fs";
import { parseManifest } from "../src/codec/manifest";
import type { FromWorker, ToWorker } from "../src/worker/messages";

/** Still chunks 1 and 2, and chunks 3 and 4, which move, in segments of one second each. */
export const TWO_SEGMENTS = readFileSync(new URL("../../tests/vectors/manifest.json", import.meta.url));

/** The same as JSON, and what it is while it has the first segment alone. */
export const WHOLE = JSON.parse(TWO_SEGMENTS.toString());
export const GROWING = firstSegment();

/** As a source hands it on: a player changes it when the scene grows. */
export const twoSegments = () => parseManifest(WHOLE);

function firstSegment() {
  const slices = WHOLE.slices.filter((slice: { segment: number }) => slice.segment === 0);
  const moving: Record<string, number>[] = slices.flatMap((slice: { chunks: unknown[] }) => slice.chunks);
  const sum = (of: string) => moving.reduce((total, chunk) => total + chunk[of], 0);
  const totals = { ...WHOLE.totals, splats_dynamic: sum("splats"), bytes_dynamic: sum("bytes") };
  const [one, two] = WHOLE.segments;
  return { ...WHOLE, live: 1, end: two.start, segments: [one], slices, totals };
}

export class WorkerDouble {
  static last: WorkerDouble;
  onmessage: ((event: { data: FromWorker }) => void) | null = null;
  readonly told: ToWorker[] = [];

  constructor() {
    WorkerDouble.last = this;
  }

  postMessage(message: ToWorker): void {
    this.told.push(message);
  }

  answer(data: FromWorker): void {
    this.onmessage?.({ data });
  }

  terminate(): void {}

  get orders() {
    return this.told.filter((message) => message.type === "order");
  }

  /** Chunks 1 to 4 have been decoded. */
  decodeAll(): void {
    const empty = new Float32Array(0);
    for (const [i, kind] of (["static", "static", "dynamic", "dynamic"] as const).entries()) {
      const id = String(i + 1).padStart(64, "0");
      this.answer({ type: "decoded", id, kind, first: 0, rows: [], texels: empty, fifth: empty });
    }
  }

  /** An order of so many splats. */
  order(count = 1): void {
    this.answer({ type: "ordered", ids: new Uint32Array(2048), count, dynamic: 0, sortTime: 1 });
  }
}
