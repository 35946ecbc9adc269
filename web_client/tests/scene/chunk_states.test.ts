import { describe, expect, it } from "vitest";
import { ChunkStates } from "../../src/scene/chunk_states";

describe("ChunkStates", () => {
  it("counts a chunk as received from its first arrival on, even when it is no longer in memory", () => {
    const states = new ChunkStates();
    states.set("a", { at: "waiting", bytes: new Uint8Array(1) });
    states.set("b", { at: "drawn", rows: [0] });
    states.set("b", { at: "evicted" });
    states.lose("c");
    expect(states.size).toBe(2);
  });

  it("settles a chunk that is drawn or lost, and no other", () => {
    const states = new ChunkStates();
    states.set("a", { at: "decoding", rows: [0] });
    expect(states.settled("a")).toBe(false);
    states.set("a", { at: "drawn", rows: [0] });
    expect(states.settled("a")).toBe(true);
    states.set("a", { at: "evicted" });
    expect(states.settled("a")).toBe(false);
    states.lose("a");
    expect(states.settled("a")).toBe(true);
  });

  it("loses no chunk that is drawn, and finds a lost one again once it is drawn", () => {
    const states = new ChunkStates();
    states.set("a", { at: "drawn", rows: [] });
    for (const id of ["a", "b"]) states.lose(id);
    expect(states.lost).toBe(1);
    states.set("b", { at: "waiting", bytes: new Uint8Array(1) });
    expect([states.lost, states.settled("b")]).toEqual([1, true]);
    states.set("b", { at: "drawn", rows: [] });
    expect(states.lost).toBe(0);
  });
});
