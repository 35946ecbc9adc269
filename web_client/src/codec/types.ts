/** Decoded chunks and manifests. Names follow the Python codec; units are those of docs/format.md. */

/** Axis-aligned box in world units. */
export interface Box {
  readonly min: readonly [number, number, number];
  readonly max: readonly [number, number, number];
}

/** Declared errors: upper bounds of the difference between the encoder's splats and the decoded ones. */
export interface Bounds {
  /** World units, per axis, at any moment, in proportion to the splat's fading. */
  readonly position: number;
  /** World units: the standard deviation that is added in every direction before shapes are compared. */
  readonly blur: number;
  /** |ln| of the ratio of standard deviations in any direction. */
  readonly shape: number;
  /** The difference at any moment. */
  readonly opacity: number;
  readonly rgb: number;
}

interface ChunkCommon {
  readonly count: number;
  /** Seconds: the segment of the splats' normalised time [0, 1]; [0, 0] in a static chunk. */
  readonly timeRange: readonly [number, number];
  /** The centres of all splats, whenever they are visible. */
  readonly box: Box;
  readonly bounds: Bounds;
  /** [N * 3] natural logarithms of the standard deviations. */
  readonly logScales: Float32Array;
  /** [N] in [0, 1]; peak sigma for dynamic splats. */
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

/** Splats that move; docs/numerics.md, "Time", has the equations. */
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
  /** World units; splats with a nearer centre are not drawn. */
  readonly near: number;
  /** 4 rows of 4. */
  readonly worldToCamera: readonly (readonly number[])[];
}

/** A camera, by name, and the part of its picture's plane to keep in view: left, top, right, bottom, pixels. */
export interface StartView {
  readonly camera: string;
  readonly box: readonly [number, number, number, number];
}

/** A chunk as the manifest lists it. */
export interface ChunkEntry {
  /** SHA-256 of the chunk's bytes, lower-case hex. */
  readonly id: string;
  readonly bytes: number;
  readonly splats: number;
  readonly box: Box;
}

/** The region around a scene's centre with trustworthy views. Angles are radians. */
export interface CapturedSpace {
  /** Unit vector at right angles to the manifest's `up`: the middle of the azimuths. */
  readonly front: readonly [number, number, number];
  /** Half of the range of azimuths, in (0, pi); null for all directions. */
  readonly azimuth: number | null;
  /** Lowest and highest. */
  readonly elevation: readonly [number, number];
  /** Nearest and farthest, world units, above 0. */
  readonly distance: readonly [number, number];
  /** Narrower limits, as the document has them. See `readSeenLimits`. */
  readonly seen?: unknown;
  /** Directions of a sparse rig's cameras, as the document has them. See `stillShare`. */
  readonly cones?: unknown;
  /** Whether to begin without static splats. */
  readonly subjectOnly?: boolean;
}

export interface SegmentEntry {
  /** Seconds. */
  readonly start: number;
  readonly end: number;
}

/** A stretch of a segment: `chunks` and `needs` hold all dynamic splats that are alive in it. */
export interface SliceEntry {
  /** Index into the manifest's segments. */
  readonly segment: number;
  /** Seconds; a slice is shown for start <= time < end, the last one at its end, too. */
  readonly start: number;
  readonly end: number;
  /** Chunks of splats that are first alive in this slice. */
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

/** Numbers of dynamic chunks and of their splats. */
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
  /** Target of an orbit camera, world. */
  readonly center: readonly [number, number, number];
  /** Typical distance of the capture's cameras from `center`, world units, above 0. */
  readonly extent: number;
  readonly cameras: readonly ManifestCamera[];
  readonly segments: readonly SegmentEntry[];
  /** Static chunks, most useful first: every prefix can be drawn. */
  readonly static: readonly ChunkEntry[];
  /** In order of time. */
  readonly slices: readonly SliceEntry[];
  readonly totals: Totals;
  /** True if thumbnail.jpg lies beside the manifest. */
  readonly thumbnail: boolean;
  readonly training: Readonly<Record<string, unknown>>;
  /** True if the splats were trained with antialiasing; false if the document does not state it. */
  readonly antialiased: boolean;
  /** Length of a world unit; null if unknown. */
  readonly metresPerUnit: number | null;
  /** The number of a growing scene's manifest, from 1; null for a complete scene. */
  readonly live: number | null;
  /** The document's entry for sound; undefined for none. See `readAudio`. */
  readonly audio?: unknown;
  /**
   * Sizes from a manifest in pages: all dynamics, and the most in two consecutive slices. Other manifests list all
   * slices.
   */
  readonly room?: { readonly all: Room; readonly most: Room };
  /** The views to begin with, on wide screens and on upright ones; none if the document does not state them. */
  readonly startViews: readonly StartView[];
  /** Whether `cameras` took the pictures that made the splats, at these sizes. */
  readonly photographed: boolean;
  /** The region around the cameras of the capture; null if the document does not state it. */
  readonly capturedSpace: CapturedSpace | null;
}

/** Supported versions of the format; the second has motions of the fifth order. */
export const VERSIONS: readonly number[] = [2, 3];
