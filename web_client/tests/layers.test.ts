import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { describe, expect, it } from "vitest";

/**
 * The rooms of src/, from the ground up: each folder, and the files that stand alone, and what each may import. Nothing is
 * imported upward.
 */
const ROOMS: Readonly<Record<string, readonly string[]>> = {
  codec: [],
  protocol: ["codec"],
  camera: ["codec"],
  source: ["codec", "protocol"],
  renderer: ["camera", "codec"],
  worker: ["camera", "codec", "renderer"],
  dom: [],
  scene: ["camera", "codec", "renderer", "source", "worker"],
  sound: ["codec", "scene"],
  player: ["camera", "codec", "renderer", "scene", "sound", "source"],
  xr: ["camera", "codec", "player", "renderer", "scene", "sound"],
  ui: ["camera", "codec", "dom", "player", "renderer", "scene", "sound", "source", "xr"],
  crop: ["camera", "dom", "player"],
  keyframes: ["camera", "crop", "dom", "player"],
  clean: ["camera", "codec", "dom", "player", "renderer", "worker"],
  upload: ["dom", "protocol"],
  console: ["camera", "clean", "crop", "dom", "keyframes", "player", "protocol", "renderer", "ui", "upload"],
  element: ["dom", "player", "ui"],
  host: ["camera", "codec", "player", "renderer", "scene", "sound", "source"],
  three: ["camera", "codec", "host", "renderer"],
  playcanvas: ["camera", "codec", "host", "renderer"],
  "index.ts": ["camera", "codec", "player", "renderer", "source", "ui"],
  "main.ts": ["console", "protocol", "ui"],
};

const SRC = join(import.meta.dirname, "../src");

const FILES = readdirSync(SRC, { recursive: true, encoding: "utf-8" }).filter((name) => /(?<!\.d)\.ts$/.test(name));

/** The files of src that each file imports, types and parts loaded later included. */
const IMPORTS: ReadonlyMap<string, readonly string[]> = new Map(
  FILES.map((file) => {
    const text = readFileSync(join(SRC, file), "utf-8");
    const names = [...text.matchAll(/\b(?:from|import)\s*\(?\s*"(\.[^"]+)"/g)].map(([, name]) => name);
    return [file, names.map((name) => relative(SRC, join(SRC, dirname(file), name)))];
  }),
);

/** The rooms that each room imports. */
function imported(): Map<string, Set<string>> {
  const found = new Map<string, Set<string>>();
  for (const [file, others] of IMPORTS) {
    const [room] = file.split("/");
    const rooms = found.get(room) ?? new Set();
    found.set(room, rooms);
    for (const other of others.map((name) => name.split("/")[0])) if (other !== room) rooms.add(other);
  }
  return found;
}

/** Files in circles, and the files above them. */
function inCircles(): string[] {
  const left = new Map([...IMPORTS].map(([file, others]) => [file, others.map((name) => `${name}.ts`)]));
  for (let before = -1; before !== left.size; ) {
    before = left.size;
    for (const [file, others] of left) if (!others.some((other) => left.has(other))) left.delete(file);
  }
  return [...left.keys()].sort();
}

describe("the rooms of src", () => {
  const found = imported();

  it("all stand in the table, and no others", () => {
    expect([...found.keys()].sort()).toEqual(Object.keys(ROOMS).sort());
  });

  it.each(Object.entries(ROOMS))("%s imports what the table says and nothing else", (room, allowed) => {
    expect([...(found.get(room) ?? [])].sort()).toEqual([...allowed].sort());
  });

  it("import nothing upward", () => {
    const order = Object.keys(ROOMS);
    for (const [room, allowed] of Object.entries(ROOMS)) {
      for (const other of allowed)
        expect(order.indexOf(other), `${room} imports ${other}`).toBeLessThan(order.indexOf(room));
    }
  });

  it("contain no circle of files", () => {
    expect(inCircles()).toEqual([]);
  });
});
