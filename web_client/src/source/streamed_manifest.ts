/** The manifest that a stream brings, from its first version to its last. */

import { parseManifest } from "../codec/manifest";
import type { Manifest } from "../codec/types";
import { continues, grown, type ManifestDocument } from "./growth";
import type { SourceFailure } from "./scene_source";

export interface StreamedManifestEvents {
  /** It has become a later version. */
  grown(manifest: Manifest): void;
  /** It has become what no stream can go on with. */
  failed(failure: SourceFailure, detail: string): void;
}

export class StreamedManifest {
  /** As the server names it; null until one is on its way. */
  id: Uint8Array | null = null;
  #document: ManifestDocument | null = null; // null while it cannot be read
  #chunks: readonly string[] = [];

  constructor(readonly events: StreamedManifestEvents) {}

  /** Whether there will be later versions. */
  get grows(): boolean {
    return this.#document?.live !== undefined;
  }

  /** Ids of its chunks, in order. */
  get chunks(): readonly string[] {
    return this.#chunks;
  }

  /** Ids of its pieces of sound. */
  get sounds(): readonly string[] {
    return this.#document?.audio?.pieces?.map(({ id }) => id) ?? [];
  }

  /** Whether it is the one that the server names so. */
  is(id: Uint8Array): boolean {
    return this.id?.length === id.length && this.id.every((byte, i) => byte === id[i]);
  }

  /** The first version has come. */
  begin(manifest: Uint8Array): void {
    this.#take(parse(manifest));
  }

  /** What has been added to it has come. */
  grow(growth: Uint8Array, id: Uint8Array): void {
    const added = parse(growth);
    this.#become(this.#document && added && grown(this.#document, added), id);
  }

  /** Another one has come in its place: a later version of the scene, or another scene's. */
  become(manifest: Uint8Array, id: Uint8Array): void {
    this.#become(parse(manifest), id);
  }

  #become(document: ManifestDocument | null, id: Uint8Array): void {
    if (!document || !this.#document || !continues(document, this.#document)) {
      this.events.failed("scene-changed", "another manifest than before");
      return;
    }
    let manifest: Manifest;
    try {
      manifest = parseManifest(document);
    } catch (error) {
      this.events.failed("not-understood", `the scene has grown into what cannot be read: ${error}`);
      return;
    }
    this.id = id;
    this.#take(document);
    this.events.grown(manifest);
  }

  #take(document: ManifestDocument | null): void {
    this.#document = document;
    this.#chunks = chunksIn(document);
  }
}

/** A manifest, or what is added to one; null for what is none, which the player finds out. */
function parse(bytes: Uint8Array): ManifestDocument | null {
  try {
    const document = JSON.parse(new TextDecoder().decode(bytes));
    return Array.isArray(document?.slices) ? document : null;
  } catch {
    return null;
  }
}

/** The ids of a manifest's chunks in order; what is no manifest, the player finds out. */
function chunksIn(document: ManifestDocument | null): string[] {
  try {
    const { static: stills = [], slices = [] } = document ?? {};
    return [...stills, ...slices.flatMap((slice) => slice.chunks)].map(({ id }) => id);
  } catch {
    return [];
  }
}
