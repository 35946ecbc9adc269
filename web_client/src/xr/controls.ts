/** The viewer's hands as commands: controllers, bare hands, and all other input sources of WebXR. */

import { add, scale, type Vec3 } from "../camera/vector";
import { Buttons } from "./buttons";
import { type RoomPose, roomPose } from "./eye_camera";
import { type EyeMatrices, ribbon } from "./flat_drawer";
import type { Hold } from "./grab";
import type { Panel } from "./panel";
import { type Control, type Ray, rayOf, shareAt } from "./panel_layout";

/** The receiver of commands. */
export interface Commands {
  togglePlay(): void;
  /** Mute or unmute; no effect without sound in the scene. */
  toggleMuted(): void;
  /** Move the playhead by a share of the scene's duration. */
  scrub(share: number): void;
  /** Move the playhead to a share of the scene's duration. */
  seek(share: number): void;
  /** Turn the viewer to the left, radians. */
  turn(angle: number): void;
  /** Return to the first size and the first view, before the viewer's present position. */
  reset(): void;
  leave(): void;
}

const SNAP = Math.PI / 6;
/** Shares of the scene's duration per second, with the stick pushed all the way. */
const SCRUB_RATE = 0.25;
const RAY = { length: 1.5, width: 0.003, colour: [1, 1, 1, 0.5] } as const;
const DOT = 0.012; // metres

/** An input source that points, in this frame. */
interface Pointer {
  readonly ray: Ray;
  /** Distance to the panel, metres; null if it points elsewhere. */
  readonly reach: number | null;
}

export class Controls {
  readonly #buttons = new Map<XRInputSource, Buttons>();
  readonly #holding = new Set<XRInputSource>();
  readonly #listeners = new AbortController();
  #dragging: XRInputSource | null = null; // source that holds the knob of the bar
  #pointers: Pointer[] = [];
  #pointed: Control | null = null;
  #head: RoomPose | null = null;
  #now = 0;

  constructor(
    readonly session: XRSession,
    readonly space: XRReferenceSpace,
    readonly panel: Panel,
    readonly commands: Commands,
  ) {
    const { signal } = this.#listeners;
    session.addEventListener("selectstart", (event) => this.#press(event), { signal });
    session.addEventListener("selectend", ({ inputSource }) => this.#release(inputSource), { signal });
    session.addEventListener("squeezestart", ({ inputSource }) => this.#hold(inputSource), { signal });
    session.addEventListener("squeezeend", ({ inputSource }) => this.#release(inputSource), { signal });
    session.addEventListener(
      "inputsourceschange",
      ({ removed }) => {
        for (const source of removed) {
          this.#release(source);
          this.#buttons.delete(source);
        }
      },
      { signal },
    );
  }

  /** The control under a pointer. */
  get pointed(): Control | null {
    return this.#dragging ? "seek" : this.#pointed;
  }

  /**
   * Read all hands in a frame at `now`, milliseconds, `passed` seconds after the last one.
   *
   * @returns the hands that hold the scene
   */
  update(frame: XRFrame, head: RoomPose, now: number, passed: number): Hold[] {
    this.#head = head;
    this.#now = now;
    this.#pointers = [];
    this.#pointed = null;
    const holds: Hold[] = [];
    for (const source of this.session.inputSources) {
      this.#point(source, frame);
      if (source.gamepad?.mapping === "xr-standard") this.#read(source, source.gamepad, passed);
      if (!this.#holding.has(source)) continue;
      const pose = this.#pose(frame, source.gripSpace ?? source.targetRaySpace);
      if (pose) holds.push({ hand: source, ...pose });
    }
    if (holds.length > 0) this.panel.wake(head, now);
    return holds;
  }

  /** Draw the pointers at the visible panel. */
  draw(eye: EyeMatrices, at: Vec3): void {
    for (const { ray, reach } of this.#pointers) {
      const end = add(ray.origin, scale(ray.direction, reach ?? RAY.length));
      this.panel.drawQuad(ribbon(ray.origin, end, RAY.width, at), eye, RAY.colour);
      if (reach === null) continue;
      const tip = add(end, [0, DOT, 0]);
      this.panel.drawQuad(ribbon(end, tip, DOT, at), eye, [1, 1, 1, 1]);
    }
  }

  dispose(): void {
    this.#listeners.abort();
  }

  #pose(frame: XRFrame, space: XRSpace): RoomPose | null {
    const pose = frame.getPose(space, this.space);
    return pose ? roomPose(pose.transform) : null;
  }

  #point(source: XRInputSource, frame: XRFrame): void {
    const pose = this.#pose(frame, source.targetRaySpace);
    if (!pose) return;
    const ray = rayOf(pose);
    if (source === this.#dragging) {
      const point = this.panel.beside(ray);
      if (point) this.commands.seek(shareAt(point.x));
      if (this.#head) this.panel.wake(this.#head, this.#now);
    }
    if (source.targetRayMode !== "tracked-pointer") return; // fingers on a screen and gazes need no ray
    const point = this.panel.pointed(ray, this.#now);
    this.#pointers.push({ ray, reach: point?.distance ?? null });
    if (!point) return;
    this.#pointed ??= point.control;
    if (this.#head) this.panel.wake(this.#head, this.#now);
  }

  #read(source: XRInputSource, gamepad: Gamepad, passed: number): void {
    const buttons = this.#buttons.get(source) ?? new Buttons();
    this.#buttons.set(source, buttons);
    const { lower, upper, flick, stick } = buttons.read(gamepad);
    if (lower) this.commands.togglePlay();
    if (upper) this.commands.leave();
    if (source.handedness === "left") {
      if (stick !== 0) this.commands.scrub(Math.sign(stick) * stick * stick * SCRUB_RATE * passed);
    } else if (flick !== 0) {
      this.commands.turn(-flick * SNAP);
    }
    if ((lower || flick !== 0 || stick !== 0) && this.#head) this.panel.wake(this.#head, this.#now);
  }

  /** Handle a press at once: a tap on a screen is over before the next frame. */
  #press({ inputSource, frame }: XRInputSourceEvent): void {
    const pose = this.#pose(frame, inputSource.targetRaySpace);
    const point = pose && this.panel.pointed(rayOf(pose), this.#now);
    if (!point) {
      this.#hold(inputSource);
      return;
    }
    if (this.#head) this.panel.wake(this.#head, this.#now);
    switch (point.control) {
      case "play":
        this.commands.togglePlay();
        break;
      case "seek":
        this.#dragging = inputSource;
        this.commands.seek(shareAt(point.x));
        break;
      case "reset":
        this.commands.reset();
        break;
      case "mute":
        this.commands.toggleMuted();
        break;
      case "leave":
        this.commands.leave();
        break;
    }
  }

  #hold(source: XRInputSource): void {
    this.#holding.add(source);
    if (this.#head) this.panel.wake(this.#head, this.#now);
  }

  #release(source: XRInputSource): void {
    this.#holding.delete(source);
    if (this.#dragging === source) this.#dragging = null;
  }
}
