import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { rigOf } from "../../src/camera/magnification";
import { parseManifest } from "../../src/codec/manifest";
import type { SplatSink } from "../../src/renderer/splat_drawer";
import { headSight } from "../../src/scene/head_sight";
import { StreamedScene } from "../../src/scene/streamed_scene";
import type { View } from "../../src/scene/view";
import type { SceneSource, SourceEvents } from "../../src/source/scene_source";
import { GROWING, TWO_SEGMENTS, twoSegments, WHOLE, WorkerDouble } from "../worker_double";

vi.mock("../../src/worker/start_worker", () => ({
  startWorker: () => new WorkerDouble(),
  decompressor: () => new Promise(() => {}),
}));

const view = (x: number): View => ({
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [x, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.1 },
});

let source: SourceEvents;
let fetchAgain: ReturnType<typeof vi.fn>;
let close: ReturnType<typeof vi.fn>;
let consumed: ReturnType<typeof vi.fn>;
let scene: StreamedScene;

beforeEach(() => {
  const ignore = () => {};
  const sink: SplatSink = {
    mostRows: 16384,
    allocate: ignore,
    writeStatics: ignore,
    writeDynamics: ignore,
    setOrder: ignore,
  };
  const open = (events: SourceEvents): SceneSource => {
    source = events;
    const silent = () => {};
    fetchAgain = vi.fn(() => new Promise<never>(() => {}));
    close = vi.fn();
    consumed = vi.fn();
    const told = { playheadAt: silent, play: silent, pause: silent, seek: silent };
    return { ...told, close, consumed, fetchAgain } as unknown as SceneSource;
  };
  scene = new StreamedScene(
    { open, sink, time: 0.5, playing: false, antialiased: null, memoryBudget: 1 },
    { manifest: ignore, changed: ignore, ordered: ignore, failed: ignore },
  );
});

afterEach(() => {
  vi.unstubAllGlobals();
});

/** The manifest has come, and all chunks. */
function begin(): void {
  source.manifest(twoSegments());
  WorkerDouble.last.decodeAll();
}

const orders = () => WorkerDouble.last.orders;
const answer = () => WorkerDouble.last.order();

describe("StreamedScene.step", () => {
  it("waits for the manifest, then for an order, and then tells what to draw", () => {
    expect(scene.step(0, [view(0)])).toBeNull();
    begin();
    expect(scene.step(16, [view(0)])?.shots).toEqual([]);
    answer();
    expect(scene.step(32, [view(0)])).toEqual({
      shots: [{ ...view(0), time: 0.5, antialiased: true, rig: rigOf(twoSegments()), still: 1 }],
      moving: false,
      settled: true,
    });
  });

  it("leaves out what stands still by the manifest's choice, and by request before that", () => {
    const space = { front: [1, 0, 0], azimuth: null, elevation: [-1, 1], distance: [1, 9] } as const;
    scene.still = ({ pose }) => pose.translation[0];
    source.manifest({ ...twoSegments(), capturedSpace: { ...space, subjectOnly: true } });
    const still = () => scene.shot(view(0.25)).still;
    expect([scene.subjectOnly, still()]).toEqual([true, 0]);
    scene.subjectOnly = false;
    expect([scene.subjectOnly, still()]).toEqual([false, 0.25]);
    scene.subjectOnly = null;
    expect([scene.subjectOnly, still()]).toEqual([true, 0]);
  });

  it("asks for one order for both eyes and draws each from where it is", () => {
    begin();
    const eyes = [view(-0.03), view(0.03)] as const;
    scene.step(0, eyes, headSight(eyes));
    expect(orders()).toMatchObject([{ request: { depth: { kind: "radial", x: 0 } } }]);
    answer();
    const shots = scene.step(16, eyes, headSight(eyes))?.shots;
    expect(shots?.map(({ pose }) => pose.translation[0])).toEqual([-0.03, 0.03]);
    expect(orders()).toHaveLength(1);
  });

  it("shows nothing before the base of the first moment is here", () => {
    source.manifest(twoSegments());
    expect(scene.step(0, [view(0)])).toEqual({ shots: [], moving: false, settled: false });
    expect(orders()).toEqual([]);
    WorkerDouble.last.decodeAll();
    scene.step(16, [view(0)]);
    expect(orders()).toHaveLength(1);
  });

  it("has a view that moves ordered quickly, and exactly once it stands", () => {
    begin();
    const shown = [0, 1, 2, 2, 2].map((x, i) => {
      const { settled } = scene.step(16 * i, [view(x)]) ?? {};
      if (orders().length > i) answer();
      return settled;
    });
    expect(orders().map(({ request }) => request.exact)).toEqual([true, false, false, true]);
    expect(shown).toEqual([false, false, false, false, true]);
  });
});

describe("a scene that plays", () => {
  const FRAME = 1000 / 60;

  /** Frames of 60 a second; the worker answers `late` frames after it was asked, before that frame begins. */
  function play(frames: number, late = 1): { clock: number; picture: number; age: number; asked: number }[] {
    begin();
    scene.playback?.play();
    const found = [];
    let answered = 0;
    let waited = 0;
    for (let i = 0; i < frames; i++) {
      if (orders().length > answered && ++waited >= late) {
        answer();
        answered++;
        waited = 0;
      }
      scene.step(i * FRAME, [view(0)]);
      const clock = scene.playback?.clock.time ?? 0;
      const asked = orders().at(-1)?.request.time ?? 0;
      found.push({ clock, picture: scene.pictureTime, age: scene.orders.ageInFrames, asked });
    }
    return found;
  }

  it("shows the playhead's moment at every frame, by an order of that very moment", () => {
    for (const { clock, picture, age } of play(60).slice(10)) {
      expect(Math.abs(picture - clock)).toBeLessThan(1e-9);
      expect(age).toBe(1);
    }
    expect(scene.orders.age).toBeCloseTo(FRAME, 6);
    expect(scene.orders.shown?.time).toBeCloseTo(scene.pictureTime, 12);
  });

  it("moves at every frame although the worker needs three of them", () => {
    const found = play(60, 3).slice(20);
    for (const { clock, picture } of found) expect(Math.abs(picture - clock)).toBeLessThanOrEqual(0.002);
    const fresh = found.filter(({ age }) => age === 3);
    expect(fresh.length).toBeGreaterThan(10);
    for (const { clock, asked } of fresh) expect(asked - clock).toBeCloseTo((3 * FRAME) / 1000, 6);
  });

  it("stays in the segment of the order until the next one's order has come", () => {
    begin();
    scene.playback?.seek(0.99);
    scene.step(0, [view(0)]);
    answer();
    scene.step(0, [view(0)]);
    scene.playback?.play();
    for (const now of [0, 5]) scene.step(now, [view(0)]);
    answer();
    const late = scene.step(45, [view(0)]);
    expect(scene.playback?.clock.time).toBeCloseTo(1.035);
    expect(late?.shots[0].time).toBe(1);
    answer();
    expect(scene.step(46, [view(0)])?.shots[0].time).toBeLessThan(0.05);
  });

  it("stands where it begins until the first picture is drawn, however late that is", () => {
    begin();
    scene.playback?.seek(0.5);
    scene.playback?.play();
    for (const now of [0, 100, 200, 300]) scene.step(now, [view(0)]);
    expect([scene.playback?.clock.time, scene.playback?.moving, scene.pictured]).toEqual([0.5, false, false]);
    answer();
    const first = scene.step(400, [view(0)]);
    expect([first?.shots[0].time, scene.playback?.clock.time, scene.pictured]).toEqual([0.5, 0.5, true]);
    scene.step(416, [view(0)]);
    expect(scene.playback?.clock.time).toBeCloseTo(0.516);
  });

  it("goes on although there is nothing to draw, once all that is alive is known to be nothing", () => {
    begin();
    scene.playback?.play();
    scene.step(0, [view(0)]);
    WorkerDouble.last.order(0);
    for (const now of [16, 32]) scene.step(now, [view(0)]);
    expect(scene.playback?.moving).toBe(true);
  });

  it("orders the very moment when it stands", () => {
    play(30);
    scene.playback?.pause();
    answer();
    scene.step(30 * FRAME, [view(0)]);
    const time = scene.playback?.clock.time;
    expect(orders().at(-1)?.request).toMatchObject({ time, from: time, until: time });
    answer();
    expect(scene.step(31 * FRAME, [view(0)])?.settled).toBe(true);
    expect(scene.pictureTime).toBe(time);
  });
});

describe("a scene that is too large", () => {
  const ids = ["a", "b", "c", "d"].map((letter) => letter.repeat(64));

  /** Four segments of a second, each of one chunk of three rows, all of which have come; there is room for two. */
  function beginLong(): void {
    const document = JSON.parse(new TextDecoder().decode(TWO_SEGMENTS));
    const segments = ids.map((_, i) => ({ start: i, end: i + 1 }));
    const box = [
      [0, 0, 0],
      [1, 1, 1],
    ];
    const slices = ids.map((id, segment) => ({
      segment,
      ...segments[segment],
      chunks: [{ id, bytes: 10, splats: 600, box }],
      needs: [],
    }));
    const totals = { splats_static: 0, splats_dynamic: 2400, bytes_static: 0, bytes_dynamic: 40 };
    const long = { ...document, end: 4, segments, static: [], slices, totals };
    source.manifest(parseManifest(long));
    for (const id of ids) source.chunk(id, new Uint8Array(10));
    decode();
  }

  /** The worker decodes what it has been told to. */
  function decode(): void {
    const { last } = WorkerDouble;
    const empty = new Float32Array(0);
    for (const message of last.told.splice(0)) {
      if (message.type !== "chunk") continue;
      const { id, rows } = message;
      last.answer({ type: "decoded", id, kind: "dynamic", first: 0, rows, texels: empty, fifth: empty });
    }
  }

  const told = () =>
    WorkerDouble.last.told.flatMap((message) => ("id" in message ? [`${message.type} ${message.id[0]}`] : []));

  it("has the chunks that the playhead needs, and ranges that say so", () => {
    beginLong();
    expect(scene.playback?.buffer.ranges()).toEqual([[0, 2]]);
    scene.playback?.seek(2.5);
    scene.step(0, [view(0)]);
    expect(told().sort()).toEqual(["chunk c", "chunk d", "evict a", "evict b"]);
    decode();
    expect(scene.playback?.buffer.ranges()).toEqual([[2, 4]]);
  });

  it("is not settled while static splats fade", () => {
    beginLong();
    scene.step(0, [view(0)]);
    answer();
    scene.shown = () => 0.5;
    expect(scene.step(16, [view(0)])?.settled).toBe(false);
    scene.shown = () => 0;
    expect(scene.step(32, [view(0)])?.settled).toBe(true);
  });

  it("goes on showing the last moment, from wherever it is seen, while the base of the next one is missing", () => {
    beginLong();
    scene.step(0, [view(0)]);
    answer();
    expect(scene.step(16, [view(0)])?.settled).toBe(true);
    scene.playback?.seek(2.5);
    expect(scene.step(32, [view(1)])?.settled).toBe(false);
    expect(orders().at(-1)?.request.time).toBe(0.5);
    answer();
    expect(scene.pictureTime).toBe(0.5);
    decode();
    scene.step(48, [view(1)]);
    answer();
    scene.step(64, [view(1)]);
    expect(orders().at(-1)?.request.time).toBe(2.5);
  });

  it("gives credit for what is decoded, and for nothing that waits", () => {
    beginLong();
    expect(consumed).toHaveBeenCalledTimes(2);
  });

  it("is complete once everything has been here, and fetches what it needs again by its id", () => {
    beginLong();
    expect(close).toHaveBeenCalled();
    scene.playback?.seek(2.5);
    scene.step(0, [view(0)]);
    decode();
    answer();
    scene.playback?.seek(0);
    scene.step(16, [view(0)]);
    expect(fetchAgain.mock.calls.map(([id, , cache]) => [id, cache])).toEqual([
      [ids[0], "default"],
      [ids[1], "default"],
    ]);
    expect(scene.playback?.buffer.ready(0)).toBe(false);
    expect(scene.playback?.buffer.complete).toBe(true);
  });
});

describe("a sink that has lost everything", () => {
  it("is given all splats once more, and shows a settled picture only then", () => {
    begin();
    const steps = [0, 16].map((now) => {
      const step = scene.step(now, [view(0)]);
      if (now === 0) answer();
      return step?.settled;
    });
    expect(steps).toEqual([false, true]);
    scene.restore();
    expect(WorkerDouble.last.told.at(-1)).toEqual({ type: "repack" });
    scene.step(32, [view(0)]);
    answer();
    expect(scene.step(48, [view(0)])?.settled).toBe(false);
    WorkerDouble.last.answer({ type: "repacked" });
    scene.step(64, [view(0)]);
    answer();
    expect(scene.step(80, [view(0)])?.settled).toBe(true);
  });
});

describe("a scene that grows", () => {
  const border = WHOLE.segments[1].start;

  it("waits at its edge, goes on when it has grown, and closes its source once all of it is here", () => {
    source.manifest(parseManifest(GROWING));
    WorkerDouble.last.decodeAll();
    expect(close).not.toHaveBeenCalled();
    scene.playback?.play();
    scene.playback?.seek(border);
    scene.step(0, [view(0)]);
    answer();
    scene.step(100, [view(0)]);
    expect([scene.playback?.atEdge, scene.playback?.clock.stalled]).toEqual([true, true]);
    source.grown(parseManifest(WHOLE));
    expect(scene.manifest?.end).toBe(WHOLE.end);
    expect(WorkerDouble.last.told.filter(({ type }) => type === "scene")).toHaveLength(2);
    expect(close).toHaveBeenCalled();
    scene.step(200, [view(0)]);
    expect(scene.playback?.clock.stalled).toBe(false);
    expect(scene.playback?.clock.time).toBeGreaterThan(border);
  });
});
