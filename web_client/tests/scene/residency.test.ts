import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ChunkStates } from "../../src/scene/chunk_states";
import { Residency } from "../../src/scene/residency";
import { entry, manifest, slice } from "../scene";

/** Ten slices of a second; each has a chunk of its own of two rows, c0 to c9. */
const scene = manifest({
  end: 10,
  slices: Array.from({ length: 10 }, (_, i) => ({ ...slice(i, i + 1, []), chunks: [entry(`c${i}`, 300)] })),
});

const bytes = (size = 10) => new Uint8Array(size);
const nothing = () => new Set<string>();

let residency: Residency;
let fetches: { id: string; resolve: (bytes: Uint8Array<ArrayBuffer>) => void; reject: (error: Error) => void }[];
let decoding: string[];
let here: Map<string, readonly number[]>; // as the worker and the textures know it
let dropped: string[];

/** Room for three chunks. */
beforeEach(() => {
  fetches = [];
  decoding = [];
  dropped = [];
  here = new Map();
  const events = {
    decode: (id: string, _: Uint8Array, rows: readonly number[]) => {
      for (const taken of here.values()) for (const row of rows) expect(taken).not.toContain(row);
      decoding.push(id);
      here.set(id, rows);
    },
    evicted: (id: string) => void here.delete(id),
    dropped: (id: string) => void dropped.push(id),
    changed: () => {},
  };
  residency = new Residency(scene, new ChunkStates(), 6, events, (id) => {
    return new Promise((resolve, reject) => fetches.push({ id, resolve, reject }));
  });
});

afterEach(() => {
  residency.dispose();
  vi.useRealTimers();
});

function decodeAll(): void {
  for (const id of decoding.splice(0)) residency.decoded(id);
}

/** The source brings these, and all that has room is decoded. */
function bring(ids: readonly number[], time = 0): void {
  for (const i of ids) residency.offer(`c${i}`, bytes());
  residency.update(time, nothing);
  decodeAll();
}

const held = () => [...here.keys()].sort();
const ALL = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];

describe("Residency", () => {
  it("decodes what fits, in the order of need, and keeps the rest as it came", () => {
    bring([3, 2, 1, 0]);
    expect(held()).toEqual(["c0", "c1", "c2"]);
  });

  it("lets what the playhead has passed make room for what waits", () => {
    bring(ALL);
    residency.update(1, nothing);
    expect(held()).toEqual(["c1", "c2", "c3"]);
    decodeAll();
    residency.update(4.5, nothing);
    expect(held()).toEqual(["c4", "c5", "c6"]);
  });

  it("never takes away what is on the screen", () => {
    bring(ALL);
    residency.update(1, () => new Set(["c0"]));
    expect(held()).toEqual(["c0", "c1", "c2"]);
    residency.update(1, nothing); // the next order is shown
    expect(held()).toEqual(["c1", "c2", "c3"]);
  });

  it("fetches again what comes around the loop, or what a seek asks for", async () => {
    bring(ALL);
    for (let time = 0; time < 10; time++) {
      residency.update(time, nothing);
      decodeAll();
    }
    expect(fetches.map(({ id }) => id)).toEqual(["c0", "c1"]); // after c9
    for (const { resolve } of fetches) resolve(bytes());
    await Promise.resolve();
    residency.update(9, nothing);
    expect(held()).toEqual(["c0", "c1", "c9"]);
    decodeAll();
    fetches.splice(0);
    residency.update(5, nothing);
    expect(fetches.map(({ id }) => id)).toEqual(["c5", "c6", "c7"]);
  });

  it("tries again later what could not be fetched", async () => {
    vi.useFakeTimers();
    bring(ALL);
    for (const time of [1, 2, 0]) {
      residency.update(time, nothing);
      decodeAll();
    }
    expect(fetches.map(({ id }) => id)).toEqual(["c0", "c1"]);
    fetches[0].reject(new Error("away"));
    await vi.advanceTimersByTimeAsync(1000);
    residency.update(0, nothing);
    expect(fetches).toHaveLength(2);
    await vi.advanceTimersByTimeAsync(2000);
    residency.update(0, nothing);
    expect(fetches.map(({ id }) => id)).toEqual(["c0", "c1", "c0"]);
  });

  it("lets go of what waits too early while the source still owes what is needed", () => {
    for (const i of [5, 6, 7, 8]) residency.offer(`c${i}`, bytes(3 << 20));
    residency.update(0, nothing);
    expect(held()).toEqual([]);
    expect(dropped).toEqual(["c7", "c8"]);
    bring([0, 1, 2]);
    expect(held()).toEqual(["c0", "c1", "c2"]);
  });

  it("decodes a damaged chunk that comes again into its rows, and gives them to others when it is lost", () => {
    residency.offer("c0", bytes());
    residency.update(0, nothing);
    const rows = here.get("c0");
    here.clear();
    residency.offer("c0", bytes());
    expect(here.get("c0")).toEqual(rows);
    here.clear();
    residency.lost("c0");
    decoding = [];
    bring([1, 2, 3]);
    expect(held()).toEqual(["c1", "c2"]); // c0 may come after all, and would be needed sooner
    residency.update(1, nothing);
    expect(held()).toEqual(["c1", "c2", "c3"]);
  });
});
