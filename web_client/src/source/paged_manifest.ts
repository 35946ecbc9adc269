/** The manifest of a long scene: an index and its pages received so far (docs/format.md, "Index and pages"). */

import { ManifestError } from "../codec/errors";
import { Field, parseManifest } from "../codec/manifest";
import { gunzip, type Page, type PieceEntry, readPage } from "../codec/page";
import type { Box, Manifest, SegmentEntry, SliceEntry } from "../codec/types";
import { GZIP, type SceneManifest } from "./scene_source";

const VERSION = 1;
/** The box of an empty set of splats. */
const NOWHERE: Box = { min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] };

interface Row extends SegmentEntry {
  readonly id: string;
  readonly bytes: number;
  readonly segments: number;
}

/**
 * Read an index, of pages or of a short scene, which is its manifest; synchronously if a proxy has undone its
 * compression.
 *
 * @param before an earlier version: its pages need not be sent again.
 * @throws SyntaxError or ManifestError, or rejects with one, if it cannot be read
 */
export function readIndex(
  bytes: Uint8Array<ArrayBuffer>,
  before?: SceneManifest,
): SceneManifest | Promise<SceneManifest> {
  if (bytes[0] === GZIP) return unpacked(bytes).then((raw) => readIndex(new Uint8Array(raw), before));
  const document = JSON.parse(new TextDecoder().decode(bytes));
  return document?.format === "hgs-index" ? new PagedManifest(document, before) : { manifest: parseManifest(document) };
}

/** Whether a manifest is a later version of another one (docs/format.md, "Scenes that grow"). */
export function continues(later: SceneManifest, earlier: SceneManifest): boolean {
  const [after, before] = [later.manifest, earlier.manifest];
  if (before.live === null || (after.live !== null && after.live <= before.live)) return false;
  const begins = (a: readonly unknown[], b: readonly unknown[]) =>
    JSON.stringify(a.slice(0, b.length)) === JSON.stringify(b);
  const full = earlier.places?.slice(0, -1); // the last page may have grown
  return (
    after.end >= before.end &&
    after.static.length === before.static.length &&
    begins(after.static, before.static) &&
    (full
      ? !later.places || begins(later.places, full)
      : begins(after.segments, before.segments) && begins(after.slices, before.slices))
  );
}

export class PagedManifest implements SceneManifest {
  manifest: Manifest;
  readonly #header: Manifest;
  readonly #rows: readonly Row[];
  /**
   * Pages by their start. A page with another id is an earlier version, and stands for the beginning of the later one.
   */
  readonly #pages: Map<number, { readonly id: string; readonly page: Page }>;

  /**
   * Start from an index.
   *
   * @throws ManifestError if a field of the index is wrong.
   */
  constructor(index: unknown, before?: SceneManifest) {
    const root = new Field("index", index);
    root.get("version").whole(VERSION, VERSION);
    this.#header = readHeader(root);
    const rows = root.get("pages").some();
    this.#rows = rows.map((field, i) => ({
      id: field.get("id").hash(),
      bytes: field.get("bytes").whole(1, 2 ** 28),
      start: field.get("start").number(),
      end: rows[i + 1]?.get("start").number() ?? this.#header.end,
      segments: field.get("segments").whole(1),
    }));
    this.#pages = new Map(before instanceof PagedManifest ? before.#pages : []);
    this.manifest = this.#composed();
  }

  get places(): [number, number][] {
    return this.#rows.map(({ start, segments }) => [start, segments]);
  }

  lacks(id: string): boolean {
    return this.#rows.some((row) => row.id === id && !this.#page(row));
  }

  async add(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<boolean> {
    if (!this.lacks(id)) return false;
    const page = await readPage(bytes);
    const row = this.#rows.find((row) => row.id === id);
    if (row?.segments !== page.segments.length) throw new ManifestError(`page ${id}`, "is not what the index says");
    this.#pages.set(row.start, { id, page });
    this.manifest = this.#composed();
    return true;
  }

  /** Without the last page of a growing scene, which may change. */
  listed(): [string, string[]][] {
    const rows = this.manifest.live === null ? this.#rows : this.#rows.slice(0, -1);
    return rows.flatMap((row) => {
      const page = this.#page(row);
      const named = page && [...page.slices.flatMap(({ chunks }) => chunks), ...page.pieces];
      return named ? [[row.id, named.map(({ id }) => id)]] : [];
    });
  }

  #page({ id, start }: Row): Page | undefined {
    const found = this.#pages.get(start);
    return found?.id === id ? found.page : undefined;
  }

  #composed(): Manifest {
    const segments: SegmentEntry[] = [];
    const slices: SliceEntry[] = [];
    const pieces: PieceEntry[] = [];
    for (const row of this.#rows) {
      const first = segments.length;
      let { start } = row;
      const known = this.#pages.get(start)?.page;
      if (known) {
        segments.push(...known.segments);
        for (const slice of known.slices) slices.push({ ...slice, segment: first + slice.segment });
        pieces.push(...known.pieces);
        start = slices[slices.length - 1].end;
      }
      if (this.#page(row)) continue;
      const end = Math.max(start, row.end);
      const page = { id: row.id, bytes: row.bytes, splats: 0, box: NOWHERE };
      slices.push({ segment: segments.length, start, end, chunks: [page], needs: [] });
      while (segments.length < first + row.segments) segments.push({ start, end });
    }
    const header = this.#header;
    const audio = header.audio && { ...header.audio, pieces };
    return { ...header, segments, slices, audio };
  }
}

async function unpacked(bytes: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> {
  try {
    return await gunzip(bytes);
  } catch (error) {
    throw new ManifestError("index", `is damaged: ${error}`);
  }
}

/** The facts of the whole scene in an index, as a manifest with one empty segment and slice. */
function readHeader(root: Field): Manifest {
  const document = root.get("manifest").object();
  const totals = root.get("manifest").get("totals").object();
  const span = { start: document.start, end: document.end };
  const manifest = parseManifest({
    ...document,
    segments: [span],
    slices: [{ ...span, segment: 0, chunks: [], needs: [] }],
    totals: { ...totals, splats_dynamic: 0, bytes_dynamic: 0 },
  });
  const room = root.get("room");
  const total = (name: string) => new Field(`index.manifest.totals.${name}`, totals[name]).whole(0);
  return {
    ...manifest,
    totals: { ...manifest.totals, splatsDynamic: total("splats_dynamic"), bytesDynamic: total("bytes_dynamic") },
    room: {
      all: { chunks: room.get("chunks").whole(0), splats: total("splats_dynamic") },
      most: { chunks: room.get("most_chunks").whole(0), splats: room.get("most_splats").whole(0) },
    },
  };
}
