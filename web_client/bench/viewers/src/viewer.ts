/** What the bench needs of a viewer. */

export type Vec3 = readonly [number, number, number];

/** A camera that looks at a point: world units, degrees. */
export interface BenchCamera {
  readonly eye: Vec3;
  readonly target: Vec3;
  readonly up: Vec3;
  /** Vertical field of view. */
  readonly fovY: number;
  readonly near: number;
  readonly far: number;
}

export interface BenchRequest {
  readonly host: HTMLElement;
  readonly width: number;
  readonly height: number;
  /** Folder of the scene's files: scene.ply, scene.splat, scene/manifest.json. */
  readonly files: URL;
  readonly camera: BenchCamera;
  /** So many there are at the scene's start. */
  readonly splats: number;
}

export interface BenchedViewer {
  readonly gl: WebGL2RenderingContext;
  look(camera: BenchCamera): void;
  /** Make the next frame draw, or draw it now. */
  draw?(): void;
  /** Whether the order of the splats is still to come. */
  busy?(): boolean;
  /** Play the scene, or let it stand. */
  play?(playing: boolean): void;
}

export type OpenViewer = (request: BenchRequest) => Promise<BenchedViewer>;

/** The canvas of a viewer that does not make its own. */
export function canvasOf({ host, width, height }: BenchRequest): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  host.append(canvas);
  return canvas;
}
