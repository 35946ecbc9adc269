import { beforeEach, expect, it } from "vitest";
import type { FromWorker } from "../../src/worker/messages";
import { WorkerScene } from "../../src/worker/worker_scene";
import { dynamicChunk, entry, manifest, slice, staticChunk } from "../scene";

const still = manifest({ static: [entry("s")], slices: [slice(0, 2, ["d", "e"])] });
const bytes = () => new Uint8Array(4);
const settle = () => new Promise((resolve) => setTimeout(resolve));

let said: FromWorker[];
let scene: WorkerScene;

beforeEach(async () => {
  said = [];
  const chunk = (id: string) => (id === "s" ? staticChunk([0, 0, 1]) : dynamicChunk([1], [0], [0], 0));
  scene = new WorkerScene(
    async (id) => {
      if (id === "bad") throw new Error("broken");
      return chunk(id);
    },
    (message) => said.push(message),
  );
  scene.receive({ type: "scene", manifest: still });
  scene.receive({ type: "chunk", id: "s", bytes: bytes(), rows: [] });
  scene.receive({ type: "chunk", id: "d", bytes: bytes(), rows: [3] });
  await settle();
});

it("tells what it has decoded, where it goes, and what it cannot decode", async () => {
  scene.receive({ type: "chunk", id: "bad", bytes: bytes(), rows: [] });
  await settle();
  expect(said).toMatchObject([
    { type: "decoded", id: "s", kind: "static", first: 0 },
    { type: "decoded", id: "d", kind: "dynamic", rows: [3] },
    { type: "failed", id: "bad", message: "broken" },
  ]);
});

it("packs once more what is in the textures, and no more what has been evicted", async () => {
  scene.receive({ type: "chunk", id: "e", bytes: bytes(), rows: [4] });
  await settle();
  scene.receive({ type: "evict", id: "d" });
  said = [];
  scene.receive({ type: "repack" });
  await settle();
  expect(said.map((message) => ("id" in message ? [message.type, message.id] : message.type))).toEqual([
    ["packed", "s"],
    ["packed", "e"],
    "repacked",
  ]);
});

it("packs nothing that is evicted while it packs", async () => {
  said = [];
  scene.receive({ type: "repack" });
  scene.receive({ type: "evict", id: "d" });
  await settle();
  expect(said).toMatchObject([{ type: "packed", id: "s" }, { type: "repacked" }]);
});

it("orders what is here", () => {
  const depth = { kind: "planar", x: 0, y: 0, z: 1, offset: 0, near: 0.1 } as const;
  const request = { depth, frustum: null, budget: Infinity, exact: true, time: 0, from: 0, until: 0 };
  scene.receive({ type: "order", request });
  scene.receive({ type: "evict", id: "d" });
  scene.receive({ type: "order", request });
  expect(said.slice(2)).toMatchObject([
    { type: "ordered", count: 2, dynamic: 1 },
    { type: "ordered", count: 1, dynamic: 0 },
  ]);
});
