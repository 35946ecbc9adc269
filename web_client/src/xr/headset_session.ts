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
import { headSight } from "../scene/head_sight";
import type { View } from "../scene/view";
import { type Commands, Controls } from "./controls";
import { type RoomPose, roomPose, scenePose } from "./eye_camera";
import { EyeLayer, NEAR } from "./eye_layer";
import type { EyeMatrices } from "./flat_drawer";
import { Grab, turned } from "./grab";
import { Outlook } from "./outlook";
import { Panel } from "./panel";
import type { Similarity } from "./similarity";
import { requestSpace, standingHere, standingPlace } from "./standing_place";
import { panelState, sceneCommands } from "./transport";

/** Distance to an eye below which splats fade, metres: nothing pops as the head moves. */
const CLEAR = 0.25;

/** sRGB and alpha. */
const ARROW = [1, 1, 1, 0.8] as const;

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
  readonly #outlook: Outlook | null; // null where the real room is seen behind the scene
  readonly #first: Similarity;
  readonly #listeners = new AbortController();
  #sceneFromRoom: Similarity;
  #head: RoomPose | null = null;
  #last = 0; // ms
  #lost = false; // the scene is out of sight
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
      const outlook = session.environmentBlendMode === "opaque" ? new Outlook(manifest, eyeHeight > 0) : null;
      new HeadsetSession(session, player, scene, standingPlace(pose, manifest, eyeHeight), space, layer, outlook);
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
    outlook: Outlook | null,
  ) {
    this.#layer = layer;
    this.#outlook = outlook;
    this.#first = first;
    this.#sceneFromRoom = first;
    const { splats, canvas } = scene.renderer;
    this.#attach(splats.gl);
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
    const views = [first.view, ...others.map(({ view }) => view)] as const;
    const step = this.scene.step(now, views, headSight(views), this.#layer.splats);
    const shots = (step?.shots ?? []).map((shot) => this.#shot(shot));
    this.#lookRound(head, shots, now);
    this.#draw(layer, eyes, shots, head, now);
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

  /** Show the panel, which brings the scene back, to a wearer without sight of it. */
  #lookRound(head: RoomPose, [shot]: readonly Shot[], now: number): void {
    if (!shot || !this.#outlook || !this.scene.playback?.buffer.staticComplete) return;
    this.#lost = this.#outlook.update(now, head, this.#sceneFromRoom, shot, this.scene.renderer.splats);
    if (this.#lost) this.#panel.wake(head, now);
  }

  #draw(layer: XRWebGLLayer, eyes: readonly Eye[], shots: readonly Shot[], head: RoomPose, now: number): void {
    const { splats } = this.scene.renderer;
    const { gl } = splats;
    const panel = this.#panel.shown(now);
    if (panel) this.#panel.paint(panelState(this.player, this.#controls.pointed, this.#lost));
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    gl.enable(gl.SCISSOR_TEST);
    eyes.forEach(({ viewport: { x, y, width, height }, matrices, position }, i) => {
      gl.scissor(x, y, width, height);
      gl.viewport(x, y, width, height);
      gl.clearColor(0, 0, 0, 0); // nothing may cover a real room
      gl.clear(gl.COLOR_BUFFER_BIT);
      this.#outlook?.backdrop.draw(matrices, position, head.position, now);
      if (shots[i]) splats.draw(shots[i], [x, y]);
      gl.viewport(x, y, width, height);
      if (this.#lost) this.#pointBack(head, matrices, position);
      if (!panel) return;
      this.#panel.draw(matrices);
      this.#controls.draw(matrices, position);
    });
    gl.disable(gl.SCISSOR_TEST);
  }

  #pointBack(head: RoomPose, matrices: EyeMatrices, eye: Vec3): void {
    for (const quad of this.#outlook?.wayBack.arrow(head, eye) ?? []) this.#panel.drawQuad(quad, matrices, ARROW);
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
        this.#sceneFromRoom = this.#head ? standingHere(this.#first, this.#head) : this.#first;
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
      this.#attach(this.scene.renderer.splats.gl);
      await this.#layer.create();
    } catch {
      this.leave(); // the page may still restore its picture
    }
  }

  #attach(gl: WebGL2RenderingContext): void {
    this.#panel.attach(gl);
    this.#outlook?.attach(gl);
  }

  #end(): void {
    this.#listeners.abort();
    this.#controls.dispose();
    this.#panel.dispose();
    this.#outlook?.dispose();
    if (this.#resume) this.player.play();
    this.scene.drive(false);
  }
}
