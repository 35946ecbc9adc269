/**
 * A scene in a headset, from entering to leaving: every frame is drawn for the current poses of the eyes, although the
 * order of the splats may be that of the previous frame; one order serves both eyes.
 */

import { startCamera } from "../camera/pinhole";
import { projectedIntrinsics, type Viewport } from "../camera/projection";
import type { Vec3 } from "../camera/vector";
import type { HgsPlayer } from "../player/hgs_player";
import type { SceneCanvas } from "../player/scene_canvas";
import type { Shot } from "../renderer/shot";
import type { View } from "../scene/view";
import { type Commands, Controls } from "./controls";
import { type RoomPose, roomPose, scenePose } from "./eye_camera";
import { EyeLayer, NEAR } from "./eye_layer";
import type { EyeMatrices } from "./flat_drawer";
import { Grab, turned } from "./grab";
import { Panel } from "./panel";
import type { Similarity } from "./similarity";
import { requestSpace, standingPlace } from "./standing_place";
import { panelState, sceneCommands } from "./transport";

/** Distance to an eye below which splats fade, metres: nothing pops as the head moves. */
const CLEAR = 0.25;

/** An eye in one frame. */
interface Eye {
  readonly viewport: Viewport;
  readonly view: View;
  readonly matrices: EyeMatrices;
  readonly position: Vec3; // room coordinates
}

export class HeadsetSession {
  readonly #layer: EyeLayer;
  readonly #controls: Controls;
  readonly #panel = new Panel();
  readonly #grab = new Grab();
  readonly #first: Similarity;
  readonly #listeners = new AbortController();
  #sceneFromRoom: Similarity;
  #head: RoomPose | null = null;
  #last = 0; // ms
  #resume = false; // whether to play when the headset shows the scene again

  /**
   * Show the player's scene in a new session, at first from its capture camera. When the session ends, for any reason,
   * the page continues by itself.
   *
   * @throws Error if the headset or the browser fails, or there is no scene; then the session has been ended
   */
  static async begin(session: XRSession, player: HgsPlayer): Promise<void> {
    try {
      const { manifest, scene } = player;
      if (!manifest || !scene) throw new Error("there is no scene to show yet");
      const layer = new EyeLayer(session, scene.renderer.splats.gl);
      await layer.create();
      const { space, eyeHeight } = await requestSpace(session);
      const { pose } = startCamera(manifest, player.camera.name);
      new HeadsetSession(session, player, scene, standingPlace(pose, manifest, eyeHeight), space, layer);
    } catch (error) {
      await session.end().catch(() => {}); // it may be over already
      throw error;
    }
  }

  private constructor(
    readonly session: XRSession,
    readonly player: HgsPlayer,
    readonly scene: SceneCanvas,
    first: Similarity,
    readonly space: XRReferenceSpace,
    layer: EyeLayer,
  ) {
    this.#layer = layer;
    this.#first = first;
    this.#sceneFromRoom = first;
    const { splats, canvas } = scene.renderer;
    this.#panel.attach(splats.gl);
    this.#controls = new Controls(session, space, this.#panel, this.#commands());
    const { signal } = this.#listeners;
    session.addEventListener("end", () => this.#end(), { signal });
    session.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    canvas.addEventListener("webglcontextlost", () => layer.forget(), { signal });
    canvas.addEventListener("webglcontextrestored", () => void this.#restore(), { signal });
    player.addEventListener("loadstart", () => this.leave(), { signal }); // another scene on the page
    scene.drive(true);
    this.#ask();
  }

  /** Leave the session; the page continues. */
  leave(): void {
    void this.session.end().catch(() => {}); // it may be over already
  }

  #ask(): void {
    this.session.requestAnimationFrame((now, frame) => this.#frame(now, frame));
  }

  #frame(now: number, frame: XRFrame): void {
    this.#ask();
    const layer = this.#layer.begin(now);
    const pose = frame.getViewerPose(this.space);
    if (!layer || !pose) return; // tracking is lost: the headset keeps the last picture
    const head = roomPose(pose.transform);
    if (!this.#head) this.#panel.wake(head, now);
    const holds = this.#controls.update(frame, head, now, this.#head ? Math.min(0.1, (now - this.#last) / 1000) : 0);
    this.#head = head;
    this.#last = now;
    this.#sceneFromRoom = this.#grab.update(this.#sceneFromRoom, holds, this.#first.scale);
    const [first, ...others] = pose.views.flatMap((view) => this.#eye(layer, view) ?? []);
    if (!first) return;
    const eyes: readonly [Eye, ...Eye[]] = [first, ...others];
    const step = this.scene.step(now, [first.view, ...others.map(({ view }) => view)], this.#layer.splats);
    this.#draw(layer, eyes, step?.shots ?? [], now);
  }

  #eye(layer: XRWebGLLayer, view: XRView): Eye | null {
    const viewport = this.#layer.viewport(layer, view);
    if (!viewport) return null;
    const pose = roomPose(view.transform);
    return {
      viewport,
      view: {
        pose: scenePose(pose, this.#sceneFromRoom),
        camera: projectedIntrinsics(view.projectionMatrix, viewport, NEAR * this.#sceneFromRoom.scale),
      },
      matrices: { projection: view.projectionMatrix, eyeFromRoom: view.transform.inverse.matrix },
      position: pose.position,
    };
  }

  #draw(layer: XRWebGLLayer, eyes: readonly Eye[], shots: readonly Shot[], now: number): void {
    const { splats, background } = this.scene.renderer;
    const { gl } = splats;
    // Nothing may cover the real room behind the scene.
    const opaque = this.session.environmentBlendMode === "opaque";
    const panel = this.#panel.shown(now);
    if (panel) this.#panel.paint(panelState(this.player, this.#controls.pointed));
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    gl.enable(gl.SCISSOR_TEST);
    eyes.forEach(({ viewport: { x, y, width, height }, matrices, position }, i) => {
      gl.scissor(x, y, width, height);
      if (opaque) gl.clearColor(...background, 1);
      else gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT);
      if (shots[i]) splats.draw(this.#shot(shots[i]), [x, y]);
      if (!panel) return;
      gl.viewport(x, y, width, height);
      this.#panel.draw(matrices);
      this.#controls.draw(matrices, position);
    });
    gl.disable(gl.SCISSOR_TEST);
  }

  /** The shot for an eye, which may be at any place, and never rests. */
  #shot(shot: Shot): Shot {
    return { ...shot, antialiased: true, clear: CLEAR * this.#sceneFromRoom.scale, widest: shot.camera.width };
  }

  #commands(): Commands {
    return {
      ...sceneCommands(this.player),
      turn: (angle) => {
        if (this.#head) this.#sceneFromRoom = turned(this.#sceneFromRoom, this.#head.position, angle);
      },
      reset: () => {
        this.#sceneFromRoom = this.#first;
      },
      leave: () => this.leave(),
    };
  }

  /** Pause while the headset is off or something covers the scene. */
  #visibility(): void {
    this.#layer.interrupted();
    if (this.session.visibilityState === "visible") {
      if (this.#resume) this.player.play();
      this.#resume = false;
    } else if (!this.player.paused) {
      this.#resume = true;
      this.player.pause();
    }
  }

  /** Continue after the player has filled the restored context. */
  async #restore(): Promise<void> {
    try {
      this.#panel.attach(this.scene.renderer.splats.gl);
      await this.#layer.create();
    } catch {
      this.leave(); // the page may still restore its picture
    }
  }

  #end(): void {
    this.#listeners.abort();
    this.#controls.dispose();
    this.#panel.dispose();
    if (this.#resume) this.player.play();
    this.scene.drive(false);
  }
}
