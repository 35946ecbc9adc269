import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Manifest } from "../../src/codec/types";
import type { StreamedScene } from "../../src/scene/streamed_scene";
import { SceneSound, type SoundingPlayer } from "../../src/sound/scene_sound";

const device = {
  state: "running",
  currentTime: 0,
  sampleRate: 48_000,
  createGain: () => ({ gain: { setTargetAtTime: () => {} }, connect: () => {} }),
  decodeAudioData: () => new Promise(() => {}),
  close: async () => {},
};
vi.mock("../../src/sound/device", () => ({
  newContext: () => device,
  outputTime: () => ({ contextTime: 0, performanceTime: 0 }),
  toSample: (seconds: number) => seconds,
}));

const piece = (start: number) => ({ id: String(start).padStart(64, "0"), bytes: 9, start, end: start + 1 });
const audio = (starts: number[]) => ({
  codec: "opus",
  sample_rate: 48_000,
  channels: 1,
  pieces: starts.map(piece),
});
const room = { all: { chunks: 0, splats: 0 }, most: { chunks: 0, splats: 0 } };

const gone = new AbortController();
const fetchAgain = vi.fn((_: string) => Promise.resolve(new Uint8Array(9)));
const fetched = () => fetchAgain.mock.calls.map(([id]) => Number(id));
let manifest: Pick<Manifest, "audio" | "room">;
let time = 0;
let player: SoundingPlayer & EventTarget;

beforeEach(() => {
  vi.stubGlobal("navigator", {});
  vi.stubGlobal("document", Object.assign(new EventTarget(), { hidden: false }));
  const target = new EventTarget();
  player = Object.assign(target, { muted: false, volume: 1, manifest: null }) as unknown as SoundingPlayer &
    EventTarget;
  Object.defineProperty(player, "manifest", { get: () => manifest });
});
afterEach(() => {
  gone.abort();
  vi.unstubAllGlobals();
});

it("plays sound that pages of the manifest bring later, and fetches nothing twice where places in the list have moved", () => {
  const clock = { rate: 1, ticked: null, after: (ahead: number) => time + ahead };
  const scene = { playback: { clock, moving: true }, source: { fetchAgain } };
  manifest = { audio: audio([]), room }; // no page has come yet
  new SceneSound(player, scene as unknown as Pick<StreamedScene, "playback" | "source">, gone.signal);
  expect(fetched()).toEqual([]);
  manifest = { audio: audio([40, 41, 42]), room };
  time = 40;
  player.dispatchEvent(new Event("frame"));
  const first = fetched();
  expect(first).toContain(40);
  manifest = { audio: audio([0, 1, 2, 40, 41, 42]), room }; // a page of the time before
  player.dispatchEvent(new Event("frame"));
  expect(fetched()).toEqual(first);
  time = 0;
  player.dispatchEvent(new Event("frame"));
  expect(fetched().slice(first.length)).toContain(0);
});
