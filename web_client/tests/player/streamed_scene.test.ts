import { readFileSync } from "node:fs";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { StreamedScene } from "../../src/player/streamed_scene";
import type { View } from "../../src/player/view";
import type { SplatSink } from "../../src/renderer/splat_drawer";
import type { SceneSource, SourceEvents } from "../../src/source/scene_source";
import type { FromWorker, ToWorker } from "../../src/worker/messages";

/** Still chunks 1 and 2, and chunks 3 and 4, which move, in segments of one second each. */
const MANIFEST = readFileSync(new URL("../../../tests/vectors/manifest.json", import.meta.url));

/** What the player has told the worker, and what answers for it. */
class FakeWorker {
  static last: FakeWorker;
  onmessage: ((event: { data: FromWorker }) => void) | null = null;
  readonly told: ToWorker[] = [];

  constructor() {
    FakeWorker.last = this;
  }

  postMessage(message: ToWorker): void {
    this.told.push(message);
  }

  answer(data: FromWorker): void {
    this.onmessage?.({ data });
  }

  terminate(): void {}
}

const view = (x: number): View => ({
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [x, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.1 },
});

let source: SourceEvents;
let scene: StreamedScene;

beforeEach(() => {
  vi.stubGlobal("Worker", FakeWorker);
  const sink: SplatSink = { allocate: () => {}, writeStatics: () => {}, writeDynamics: () => {}, setOrder: () => {} };
  const open = (events: SourceEvents): SceneSource => {
    source = events;
    const silent = () => {};
    return { playheadAt: silent, play: silent, pause: silent, seek: silent, close: silent } as unknown as SceneSource;
  };
  const ignore = () => {};
  scene = new StreamedScene(
    { open, sink, time: 0.5, playing: false, antialiased: null },
    { manifest: ignore, changed: ignore, ordered: ignore, failed: ignore },
  );
});

afterEach(() => {
  vi.unstubAllGlobals();
});

/** The manifest has come, and all chunks. */
function begin(): void {
  source.manifest(MANIFEST);
  const empty = new Float32Array(0);
  for (const [i, kind] of (["static", "static", "dynamic", "dynamic"] as const).entries()) {
    const id = String(i + 1).padStart(64, "0");
    FakeWorker.last.answer({ type: "decoded", id, kind, first: 0, texels: empty, fifth: empty });
  }
}

const orders = () => FakeWorker.last.told.filter((message) => message.type === "order");
const answer = () =>
  FakeWorker.last.answer({
    type: "ordered",
    ids: new Uint32Array(2048),
    count: 1,
    dynamic: 0,
    normalisedTime: 0.25,
    sortTime: 1,
  });

describe("StreamedScene.step", () => {
  it("waits for the manifest, then for an order, and then tells what to draw", () => {
    expect(scene.step(0, [view(0)])).toBeNull();
    begin();
    expect(scene.step(16, [view(0)])?.shots).toEqual([]);
    answer();
    expect(scene.step(32, [view(0)])).toEqual({
      shots: [{ ...view(0), time: 0.25, antialiased: true }],
      moving: false,
      settled: true,
    });
  });

  it("asks for one order for both eyes and draws each from where it is", () => {
    begin();
    scene.step(0, [view(-0.03), view(0.03)]);
    expect(orders()).toMatchObject([{ depth: { kind: "radial", x: 0 } }]);
    answer();
    const shots = scene.step(16, [view(-0.03), view(0.03)])?.shots;
    expect(shots?.map(({ pose }) => pose.translation[0])).toEqual([-0.03, 0.03]);
    expect(orders()).toHaveLength(1);
  });
});
