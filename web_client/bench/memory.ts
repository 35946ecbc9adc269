/**
 * How much memory a long scene takes while it plays: `npm run bench:memory`. Ten minutes of 300,000 splats at a time, made
 * up and never encoded, pass through the player and the worker's part of the scene; textures are counted, not made.
 */

import { parseManifest } from "../src/codec/manifest";
import type { DynamicChunk } from "../src/codec/types";
import { DYNAMICS_PER_ROW, TEXTURE_WIDTH } from "../src/renderer/layout";
import type { SplatSink } from "../src/renderer/splat_drawer";
import { StreamedScene } from "../src/scene/streamed_scene";
import type { View } from "../src/scene/view";
import type { SceneSource, SourceEvents } from "../src/source/scene_source";
import type { FromWorker, ToWorker } from "../src/worker/messages";
import { WorkerScene } from "../src/worker/worker_scene";
import { random } from "../tests/random";

const MINUTES = 10;
const SEGMENT = 2; // seconds
const CHUNKS = 10; // of a segment
const SPLATS = 30_000; // of a chunk
const COMPRESSED = 18 * SPLATS; // bytes
const AHEAD = 16 << 20; // bytes that may wait undecoded, as in the sources
const MB = 1 << 20;

/** Splats that are seen for their whole segment, in the order of the chunk. */
function moving(): DynamicChunk {
  const next = random(1);
  const floats = (count: number, value: () => number) => Float32Array.from({ length: count }, value);
  const box = { min: [-1, -1, -1], max: [1, 1, 1] } as const;
  return {
    kind: "dynamic",
    count: SPLATS,
    timeRange: [0, SEGMENT],
    box,
    bounds: { position: 0, blur: 0, shape: 0, opacity: 0, rgb: 0 },
    motion: floats(12 * SPLATS, () => next() - 0.5),
    rotation: floats(8 * SPLATS, next),
    logScales: new Float32Array(3 * SPLATS).fill(-5),
    opacities: new Float32Array(SPLATS).fill(0.5),
    rgb: floats(3 * SPLATS, next),
    timeCenters: new Float32Array(SPLATS).fill(0.5),
    timeLogPrecisions: new Float32Array(SPLATS).fill(-9),
  };
}

const box = [
  [-1, -1, -1],
  [1, 1, 1],
];
const segments = Array.from({ length: (60 * MINUTES) / SEGMENT }, (_, i) => ({
  start: i * SEGMENT,
  end: (i + 1) * SEGMENT,
}));
const slices = segments.map((span, segment) => ({
  segment,
  ...span,
  chunks: Array.from({ length: CHUNKS }, (_, i) => ({
    id: (segment * CHUNKS + i).toString(16).padStart(64, "0"),
    bytes: COMPRESSED,
    splats: SPLATS,
    box,
  })),
  needs: [],
}));
const ids = slices.flatMap(({ chunks }) => chunks.map(({ id }) => id));
const document = {
  format: "hgs-scene",
  version: 2,
  title: "long",
  start: 0,
  end: 60 * MINUTES,
  frame_rate: 30,
  background: [0, 0, 0],
  up: [0, -1, 0],
  center: [0, 0, 0],
  extent: 3,
  cameras: [
    {
      ...{ name: "a", width: 64, height: 64, fx: 64, fy: 64, cx: 32, cy: 32, near: 0.1 },
      world_to_camera: [0, 1, 2, 3].map((i) => [0, 1, 2, 3].map((k) => Number(i === k))),
    },
  ],
  segments,
  static: [],
  slices,
  totals: {
    splats_static: 0,
    splats_dynamic: ids.length * SPLATS,
    bytes_static: 0,
    bytes_dynamic: ids.length * COMPRESSED,
  },
  thumbnail: false,
  training: {},
};

const template = moving();

/** As decoded, with arrays of its own. */
function decoded(): DynamicChunk {
  const own = Object.entries(template).map(([name, value]) => [
    name,
    value instanceof Float32Array ? value.slice() : value,
  ]);
  return Object.fromEntries(own) as DynamicChunk;
}

class WorkerHere {
  onmessage: ((event: { data: FromWorker }) => void) | null = null;
  readonly #scene = new WorkerScene(
    async () => decoded(),
    (data) => setImmediate(() => this.onmessage?.({ data })),
  );

  postMessage(message: ToWorker): void {
    if (message.type !== "decompressor") setImmediate(() => this.#scene.receive(message));
  }

  terminate(): void {}
}

/** Brings chunks in their order, as far ahead as is decoded, and those that are asked for again. */
class Source implements SceneSource {
  fetchedAgain = 0;
  brought = 0;
  #waiting = 0;

  constructor(readonly events: SourceEvents) {}

  begin(): void {
    this.events.manifest(parseManifest(document));
    this.#bring();
  }

  consumed(bytes: number): void {
    this.#waiting -= bytes;
    this.#bring();
  }

  async fetchAgain(): Promise<Uint8Array<ArrayBuffer>> {
    this.fetchedAgain++;
    return new Uint8Array(COMPRESSED);
  }

  play(): void {}
  pause(): void {}
  seek(): void {}
  playheadAt(): void {}
  wake(): void {}
  close(): void {}

  #bring(): void {
    while (this.brought < ids.length && this.#waiting <= AHEAD) {
      this.#waiting += COMPRESSED;
      this.events.chunk(ids[this.brought++], new Uint8Array(COMPRESSED));
    }
  }
}

const sink = {
  mostRows: 16384,
  bytes: 0,
  ids: 0,
  allocate(_: number, rows: number) {
    this.bytes = rows * TEXTURE_WIDTH * 16;
  },
  writeStatics() {},
  writeDynamics() {},
  setOrder(order: Uint32Array) {
    this.ids = 4 * order.length;
  },
};

/** Of no function: what stands in for the decompressor. */
const EMPTY_MODULE = Uint8Array.of(0, 97, 115, 109, 1, 0, 0, 0);
Object.assign(globalThis, {
  Worker: WorkerHere,
  location: { origin: "null" },
  fetch: async () => new Response(EMPTY_MODULE),
});
const memoryBudget = process.argv[2] ? Number(process.argv[2]) * MB : undefined;
let source: Source | undefined;
const ignore = () => {};
const scene = new StreamedScene(
  {
    open: (events) => {
      source = new Source(events);
      return source;
    },
    sink: sink satisfies SplatSink,
    time: 0,
    playing: true,
    antialiased: null,
    memoryBudget,
  },
  { manifest: ignore, changed: ignore, ordered: ignore, failed: (_, cause) => process.stdout.write(`${cause}\n`) },
);
source?.begin();
const view: View = {
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 2] },
  camera: { width: 64, height: 64, fx: 64, fy: 64, cx: 32, cy: 32, near: 0.1 },
};

/** Of the page and the worker together. */
function inMemory(): number {
  globalThis.gc?.();
  const { heapUsed, arrayBuffers } = process.memoryUsage();
  return heapUsed + arrayBuffers;
}

let most = 0;
let stalled = 0;
const begun = inMemory();
const frames = (60 * MINUTES) / 0.1;
for (let frame = 0; frame < 2 * frames && (scene.playback?.clock.time ?? 0) < 60 * MINUTES - 0.2; frame++) {
  scene.step(frame * 100, [view]);
  for (let i = 0; i < 8; i++) await new Promise((resolve) => setImmediate(resolve));
  if (scene.playback?.clock.stalled) stalled++;
  if (frame % 50 === 0) most = Math.max(most, inMemory() - begun);
}
const device = sink.bytes + sink.ids;
const numbers = {
  "scene, splats": ids.length * SPLATS,
  "played, s": scene.playback?.clock.time.toFixed(0),
  "splats in the last order": scene.orders.count,
  "on the device, MB": (device / MB).toFixed(0),
  "page and worker at most, MB": (most / MB).toFixed(0),
  "in all, MB": ((device + most) / MB).toFixed(0),
  "rows taken, splats": (sink.bytes / 16 / TEXTURE_WIDTH) * DYNAMICS_PER_ROW,
  "chunks fetched again": source?.fetchedAgain,
  "frames that waited": stalled,
};
for (const [name, value] of Object.entries(numbers)) process.stdout.write(`${name}: ${value}\n`);
scene.dispose();
