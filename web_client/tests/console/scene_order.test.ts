import { describe, expect, it } from "vitest";
import { arrange, isOrder } from "../../src/console/scene_order";
import type { Scene } from "../../src/protocol/api";

const scene = (id: string, title: string, created: number, seconds: number, bytes: number): Scene => ({
  id,
  title,
  created,
  start: 1,
  end: 1 + seconds,
  bytes_total: bytes,
  splats_static: 1,
  splats_dynamic: 1,
  live: false,
});

const SCENES = [
  scene("b", "Take 10", 3, 2, 500),
  scene("a", "take 2", 1, 9, 100),
  scene("c-studio", "", 2, 0, 900),
  scene("d", "Étude in the hall", 4, 4, 300),
];

const ids = (search: string, order: Parameters<typeof arrange>[2] = "newest") =>
  arrange(SCENES, search, order).map(({ id }) => id);

describe("arrange", () => {
  it("sorts by what is asked for", () => {
    expect(ids("")).toEqual(["d", "b", "c-studio", "a"]);
    expect(ids("", "longest")).toEqual(["a", "d", "b", "c-studio"]);
    expect(ids("", "largest")).toEqual(["c-studio", "b", "d", "a"]);
  });

  it("sorts numbers in names as numbers, and scenes without a title by their id", () => {
    expect(ids("", "name")).toEqual(["c-studio", "d", "a", "b"]);
  });

  it("finds every word, whatever its case and accents, in title or id", () => {
    expect(ids("TAKE")).toEqual(["b", "a"]);
    expect(ids("hall etude")).toEqual(["d"]);
    expect(ids("studio")).toEqual(["c-studio"]);
    expect(ids("take etude")).toEqual([]);
    expect(ids("  ")).toHaveLength(4);
  });

  it("leaves the list it was given as it is", () => {
    arrange(SCENES, "", "name");
    expect(SCENES.map(({ id }) => id)).toEqual(["b", "a", "c-studio", "d"]);
  });
});

it("knows its orders", () => {
  expect([isOrder("name"), isOrder("toString"), isOrder("")]).toEqual([true, false, false]);
});
