/** What splats are drawn into when a host draws with them, such as an engine with meshes of its own. */

type Row = readonly [number, number, number, number];

export interface HostSurface {
  /**
   * Two rows of a matrix that takes a point before the camera (OpenCV axes, the scene's units, then 1) to the host's clip
   * space: its z and its w. A splat has the depth of its centre all over.
   */
  readonly z: Row;
  readonly w: Row;
  /** 2 / log2(far + 1) where the host writes depth as log2(1 + w) / log2(far + 1); else 0. */
  readonly logarithmic: number;
  /** Whether what is near has the greater depth. */
  readonly reversed: boolean;
  /** Whether colours are written in linear light; else in sRGB, as they are. */
  readonly linear: boolean;
}
