/** The manifest of a scene, checked field by field (docs/format.md, "Manifest"). */

import { ManifestError } from "./errors";
import {
  type Box,
  type CapturedSpace,
  type ChunkEntry,
  type Manifest,
  type ManifestCamera,
  type SegmentEntry,
  type SliceEntry,
  type StartView,
  VERSIONS,
} from "./types";

/** A value inside the document. Every reader throws ManifestError if the value has another type. */
export class Field {
  constructor(
    readonly path: string,
    readonly value: unknown,
  ) {}

  error(expected: string): ManifestError {
    return new ManifestError(this.path, `is ${JSON.stringify(this.value)?.slice(0, 40)}, expected ${expected}`);
  }

  object(): Record<string, unknown> {
    if (typeof this.value !== "object" || this.value === null || Array.isArray(this.value))
      throw this.error("an object");
    return this.value as Record<string, unknown>;
  }

  has(name: string): boolean {
    return Object.hasOwn(this.object(), name);
  }

  /** Undefined if the field is absent. */
  given(name: string): Field | undefined {
    return this.has(name) ? this.get(name) : undefined;
  }

  get(name: string): Field {
    if (!this.has(name)) throw new ManifestError(`${this.path}.${name}`, "is missing");
    return new Field(`${this.path}.${name}`, this.object()[name]);
  }

  items(count?: number): Field[] {
    if (!Array.isArray(this.value) || (count !== undefined && this.value.length !== count)) {
      throw this.error(count === undefined ? "a list" : `a list of ${count}`);
    }
    return this.value.map((entry, i) => new Field(`${this.path}[${i}]`, entry));
  }

  some(): Field[] {
    const items = this.items();
    if (items.length === 0) throw this.error("at least one");
    return items;
  }

  text(): string {
    if (typeof this.value !== "string") throw this.error("a string");
    return this.value;
  }

  flag(): boolean {
    if (typeof this.value !== "boolean") throw this.error("true or false");
    return this.value;
  }

  hash(): string {
    if (!/^[0-9a-f]{64}$/.test(this.text())) throw this.error("64 lower-case hex digits");
    return this.text();
  }

  number(low = Number.NEGATIVE_INFINITY): number {
    if (typeof this.value !== "number" || !Number.isFinite(this.value)) throw this.error("a finite number");
    if (this.value < low) throw this.error(`at least ${low}`);
    return this.value;
  }

  positive(): number {
    if (this.number() <= 0) throw this.error("above 0");
    return this.number();
  }

  whole(low: number, high = Number.MAX_SAFE_INTEGER): number {
    if (!Number.isSafeInteger(this.value) || this.number() < low || this.number() > high) {
      throw this.error(`a whole number from ${low} to ${high}`);
    }
    return this.number();
  }

  /** Two numbers, the first no greater than the second. */
  range(): [number, number] {
    const [low, high] = this.items(2).map((entry) => entry.number());
    if (low > high) throw this.error("ascending numbers");
    return [low, high];
  }

  triple(): [number, number, number] {
    return this.items(3).map((entry) => entry.number()) as [number, number, number];
  }
}

/** Read the result of JSON.parse; unknown fields are ignored. Throws ManifestError. */
export function parseManifest(json: unknown): Manifest {
  const root = new Field("manifest", json);
  if (root.get("format").text() !== "hgs-scene") throw root.get("format").error('"hgs-scene"');
  const version = root.get("version").whole(1);
  if (!VERSIONS.includes(version)) throw root.get("version").error(VERSIONS.join(" or "));
  const totals = root.get("totals");
  const segments = root.get("segments").some().map(readSpan);
  const manifest: Manifest = {
    version,
    title: root.get("title").text(),
    ...readSpan(root),
    frameRate: root.get("frame_rate").positive(),
    background: root.get("background").triple(),
    up: root.get("up").triple(),
    center: root.get("center").triple(),
    extent: root.get("extent").positive(),
    cameras: root.get("cameras").some().map(readCamera),
    segments,
    static: root.get("static").items().map(readChunk),
    slices: root
      .get("slices")
      .some()
      .map((field) => readSlice(field, segments.length)),
    totals: {
      splatsStatic: totals.get("splats_static").whole(0),
      splatsDynamic: totals.get("splats_dynamic").whole(0),
      bytesStatic: totals.get("bytes_static").whole(0),
      bytesDynamic: totals.get("bytes_dynamic").whole(0),
    },
    thumbnail: root.get("thumbnail").flag(),
    training: root.get("training").object(),
    antialiased: root.given("antialiased")?.flag() ?? false,
    live: root.given("live")?.whole(1) ?? null,
    metresPerUnit: root.given("metres_per_unit")?.positive() ?? null,
    audio: root.object().audio,
    startViews: (root.given("start_views")?.items(2) ?? []).map(readStartView),
    photographed: root.given("photographed")?.flag() ?? root.has("captured_space"),
    capturedSpace: readCapturedSpace(root.given("captured_space")),
  };
  checkReferences(manifest, root);
  return manifest;
}

function readSpan(field: Field): SegmentEntry {
  const start = field.get("start").number();
  return { start, end: field.get("end").number(start) };
}

function readCamera(field: Field): ManifestCamera {
  return {
    name: field.get("name").text(),
    width: field.get("width").whole(1),
    height: field.get("height").whole(1),
    fx: field.get("fx").positive(),
    fy: field.get("fy").positive(),
    cx: field.get("cx").number(),
    cy: field.get("cy").number(),
    near: field.get("near").positive(),
    worldToCamera: field
      .get("world_to_camera")
      .items(4)
      .map((row) => row.items(4).map((entry) => entry.number())),
  };
}

function readStartView(field: Field): StartView {
  const [left, top, right, bottom] = field
    .get("box")
    .items(4)
    .map((entry) => entry.number());
  if (left >= right || top >= bottom) throw field.get("box").error("ascending corners");
  return { camera: field.get("camera").text(), box: [left, top, right, bottom] };
}

function readCapturedSpace(field: Field | undefined): CapturedSpace | null {
  if (!field) return null;
  const front = field.get("front").triple();
  const azimuth = field.given("azimuth")?.positive() ?? null;
  if (azimuth !== null && azimuth >= Math.PI) throw field.get("azimuth").error("below pi");
  const distance = field.get("distance").range();
  if (distance[0] <= 0) throw field.get("distance").error("numbers above 0");
  const { seen, cones } = field.object();
  const subjectOnly = field.given("subject_only")?.flag();
  return { front, azimuth, elevation: field.get("elevation").range(), distance, seen, cones, subjectOnly };
}

function readChunk(field: Field): ChunkEntry {
  const [min, max] = field.get("box").items(2);
  const box: Box = { min: min.triple(), max: max.triple() };
  if (box.min.some((low, axis) => low > box.max[axis])) throw field.get("box").error("ascending corners");
  return {
    id: field.get("id").hash(),
    bytes: field.get("bytes").whole(1, 2 ** 28),
    splats: field.get("splats").whole(1, 2 ** 20),
    box,
  };
}

function readSlice(field: Field, segments: number): SliceEntry {
  return {
    segment: field.get("segment").whole(0, segments - 1),
    ...readSpan(field),
    chunks: field.get("chunks").items().map(readChunk),
    needs: field
      .get("needs")
      .items()
      .map((entry) => entry.hash()),
  };
}

/** Check the relations between fields: order of time, references, totals. */
function checkReferences(manifest: Manifest, root: Field): void {
  const known = new Set(manifest.static.map((chunk) => chunk.id));
  if (known.size < manifest.static.length) throw root.get("static").error("every chunk once");
  for (const [i, segment] of manifest.segments.entries()) {
    if (i > 0 && segment.start < manifest.segments[i - 1].start) {
      throw root.get("segments").items()[i].get("start").error("no earlier than the one before");
    }
  }
  const segmentOf = new Map<string, number>();
  for (const [i, slice] of manifest.slices.entries()) {
    const field = root.get("slices").items()[i];
    if (i > 0 && slice.start < manifest.slices[i - 1].start)
      throw field.get("start").error("no earlier than the one before");
    for (const [n, id] of slice.needs.entries()) {
      if (segmentOf.get(id) !== slice.segment) {
        throw field.get("needs").items()[n].error("a chunk of an earlier slice of the segment");
      }
    }
    for (const [n, { id }] of slice.chunks.entries()) {
      if (known.has(id)) throw field.get("chunks").items()[n].get("id").error("every chunk once");
      known.add(id);
      segmentOf.set(id, slice.segment);
    }
  }
  const dynamic = manifest.slices.flatMap((slice) => slice.chunks);
  for (const [kind, chunks] of Object.entries<readonly ChunkEntry[]>({ static: manifest.static, dynamic })) {
    for (const of of ["splats", "bytes"] as const) {
      const stated = root.get("totals").get(`${of}_${kind}`);
      const total = chunks.reduce((sum, chunk) => sum + chunk[of], 0);
      if (stated.value !== total) throw stated.error(`${total}, the sum over the chunks`);
    }
  }
}
