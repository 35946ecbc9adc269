/** What a chunk decodes to, and what a manifest says. Names follow the Python codec; units are those of docs/format.md. */

/** Axis-aligned box in world units. */
export interface Box {
  readonly min: readonly [number, number, number];
  readonly max: readonly [number, number, number];
}

/** Declared errors: no splat of the chunk is farther from the encoder's than this. */
export interface Bounds {
  /** World units, per axis, at any moment, in proportion to how far the splat has faded. */
  readonly position: number;
  /** World units: the standard deviation added in every direction before shapes are compared. */
  readonly blur: number;
  /** Of |ln| of the ratio of standard deviations in any direction. */
  readonly shape: number;
  /** At any moment. */
  readonly opacity: number;
  readonly rgb: number;
}

interface ChunkCommon {
  readonly count: number;
  /** Seconds: the segment whose normalised time [0, 1] the splats use; [0, 0] in a static chunk. */
  readonly timeRange: readonly [number, number];
  /** Holds the centre of every splat whenever it can be seen. */
  readonly box: Box;
  readonly bounds: Bounds;
  /** [N * 3] natural logarithms of the standard deviations. */
  readonly logScales: Float32Array;
  /** [N] in [0, 1]; of dynamic splats the peak sigma. */
  readonly opacities: Float32Array;
  /** [N * 3] sRGB, nominally in [0, 1]. */
  readonly rgb: Float32Array;
}

/** Splats that never change. */
export interface StaticChunk extends ChunkCommon {
  readonly kind: "static";
  /** [N * 3] world units. */
  readonly means: Float32Array;
  /** [N * 4] unit quaternions w, x, y, z. */
  readonly quats: Float32Array;
}

/** Splats that move: the equations are in docs/numerics.md, "Time". */
export interface DynamicChunk extends ChunkCommon {
  readonly kind: "dynamic";
  /** [N * K * 3] position polynomial in d = t - timeCenters, constant first, x y z each; K is 6 if a splat moves in the
   * fifth order, else 4. */
  readonly motion: Float32Array;
  /** [N * 2 * 4] rotation polynomial in d, w x y z each; the constant is a unit quaternion. */
  readonly rotation: Float32Array;
  /** [N] normalised time. */
  readonly timeCenters: Float32Array;
  /** [N] ln s, s in 1 / normalised time squared. */
  readonly timeLogPrecisions: Float32Array;
}

export type DecodedChunk = StaticChunk | DynamicChunk;

/** A camera of the capture: OpenCV axes, pixel centres at +0.5. */
export interface ManifestCamera {
  readonly name: string;
  readonly width: number;
  readonly height: number;
  readonly fx: number;
  readonly fy: number;
  readonly cx: number;
  readonly cy: number;
  /** World units; splats whose centre is nearer are not drawn. */
  readonly near: number;
  /** 4 rows of 4. */
  readonly worldToCamera: readonly (readonly number[])[];
}

/** A chunk as the manifest lists it. */
export interface ChunkEntry {
  /** SHA-256 of the chunk's bytes, lower-case hex. */
  readonly id: string;
  readonly bytes: number;
  readonly splats: number;
  readonly box: Box;
}

/** The part of space around a scene's centre from which it can be looked at with trust. Angles are radians. */
export interface CapturedSpace {
  /** Unit vector at right angles to the manifest's `up`: the middle of the azimuths. */
  readonly front: readonly [number, number, number];
  /** Half of the range of azimuths, in (0, pi); null: all round. */
  readonly azimuth: number | null;
  /** Lowest and highest. */
  readonly elevation: readonly [number, number];
  /** Nearest and farthest, world units, above 0. */
  readonly distance: readonly [number, number];
  /** Narrower limits, as the document has them. See `readSeenLimits`. */
  readonly seen?: unknown;
}

export interface SegmentEntry {
  /** Seconds. */
  readonly start: number;
  readonly end: number;
}

/** A stretch of a segment: at any moment of it, the living dynamic splats are in `chunks` and `needs`. */
export interface SliceEntry {
  /** Index into the manifest's segments. */
  readonly segment: number;
  /** Seconds; a slice is shown for start <= time < end, the last one also at its end. */
  readonly start: number;
  readonly end: number;
  /** Chunks whose splats are first alive in this slice. */
  readonly chunks: readonly ChunkEntry[];
  /** Ids of chunks of earlier slices with splats that are still alive in this one. */
  readonly needs: readonly string[];
}

export interface Totals {
  readonly splatsStatic: number;
  readonly splatsDynamic: number;
  readonly bytesStatic: number;
  readonly bytesDynamic: number;
}

/** How many chunks that move there are, with how many splats. */
export interface Room {
  readonly chunks: number;
  readonly splats: number;
}

export interface Manifest {
  readonly version: number;
  readonly title: string;
  /** Seconds of the capture's clock. */
  readonly start: number;
  readonly end: number;
  /** Frames per second, above 0. */
  readonly frameRate: number;
  readonly background: readonly [number, number, number];
  /** Unit vector, world. */
  readonly up: readonly [number, number, number];
  /** Point that an orbit camera turns about, world. */
  readonly center: readonly [number, number, number];
  /** Typical distance of the capture's cameras from `center`, world units, above 0. */
  readonly extent: number;
  readonly cameras: readonly ManifestCamera[];
  readonly segments: readonly SegmentEntry[];
  /** Static chunks, most useful first: any prefix draws. */
  readonly static: readonly ChunkEntry[];
  /** In order of time. */
  readonly slices: readonly SliceEntry[];
  readonly totals: Totals;
  /** True if thumbnail.jpg lies beside the manifest. */
  readonly thumbnail: boolean;
  readonly training: Readonly<Record<string, unknown>>;
  /** True if the splats were trained to be drawn with antialiasing; false where the document does not say. */
  readonly antialiased: boolean;
  /** Length of a world unit; null where it is not known. */
  readonly metresPerUnit: number | null;
  /** The scene grows, and this is its manifest's number, from 1; null: it is complete. */
  readonly live: number | null;
  /** What is heard, as the document has it; undefined for nothing. See `readAudio`. */
  readonly audio?: unknown;
  /** Of a manifest in pages: all that moves, and the most of two slices that follow each other; else the slices say so. */
  readonly room?: { readonly all: Room; readonly most: Room };
  /** Whether `cameras` took the pictures that made the splats, at these sizes. */
  readonly photographed: boolean;
  /** From where the pictures were taken; null where the document does not say. */
  readonly capturedSpace: CapturedSpace | null;
}
