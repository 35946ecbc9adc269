/** The crop tool: a box over the picture around the part of a scene to keep, and the start of its edit. */

import { project } from "../camera/pinhole";
import { row } from "../camera/vector";
import { EditApplication, type StartEdit } from "../dom/edit_application";
import { adoptStyle } from "../dom/shadow_style";
import toolCss from "../dom/tool_panel.css?inline";
import type { HgsPlayer } from "../player/hgs_player";
import css from "./crop.css?inline";
import { type CropBox, type CropWish, documentFor, uprightBox } from "./crop_box";
import { dragged, type Handle } from "./crop_drag";
import { CropDrawing } from "./crop_drawing";
import { CropPanel } from "./crop_panel";
import { cropViewOf, type Pixel } from "./crop_view";

/** Side of the first box, as a share of the smaller side of the picture at its distance. */
const FIRST_SIDE = 0.36;

/** Width of a player, CSS pixels, below which the panel covers as little as possible. */
const NARROW = 620;

export class CropTool {
  readonly #drawing: CropDrawing;
  readonly #panel: CropPanel;
  readonly #application: EditApplication;
  #box: CropBox | null = null;
  #inverse = false;
  #document = ""; // the shown crop as an edit
  #frame = 0; // 0 without a requested frame

  /**
   * Create the tool.
   *
   * @param root root element of the player, in its shadow root.
   */
  constructor(
    readonly player: HgsPlayer,
    readonly root: HTMLElement,
    startEdit: StartEdit,
  ) {
    for (const style of [toolCss, css]) adoptStyle(root.getRootNode() as ShadowRoot, style);
    const signal = player.disposed;
    this.#drawing = new CropDrawing((handle, event, group) => this.#grab(handle, event, group), signal);
    this.#application = new EditApplication(startEdit, () => this.#document);
    const events = {
      changed: (box: CropBox) => this.#change(box),
      inverted: (inverse: boolean) => {
        this.#inverse = inverse;
        this.#draw();
      },
      reset: () => this.#change(this.#firstBox()),
      close: () => this.toggle(),
    };
    this.#panel = new CropPanel(events, this.#application.nodes);
    player.addEventListener("loadstart", () => this.#forget(), { signal });
    for (const type of ["viewchange", "timeupdate"] as const) {
      player.addEventListener(type, () => this.#drawSoon(), { signal });
    }
    const sizes = new ResizeObserver(() => this.#drawSoon());
    sizes.observe(root);
    signal.addEventListener("abort", () => sizes.disconnect());
  }

  /** Whether the box is shown. */
  get active(): boolean {
    return this.#panel.node.isConnected;
  }

  toggle(): void {
    if (this.active) {
      this.#drawing.node.remove();
      this.#panel.node.remove();
      this.root.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
      return;
    }
    this.#box ??= this.#firstBox();
    if (!this.#box) return;
    this.root.querySelector(".stage")?.after(this.#drawing.node);
    this.root.append(this.#panel.node);
    this.#panel.compact = this.root.clientWidth < NARROW;
    this.#draw();
  }

  /** A box in the middle of the captured scene, entirely in the picture; null without a scene. */
  #firstBox(): CropBox | null {
    const { manifest } = this.player;
    const view = this.#view();
    if (!manifest || !view) return null;
    const { center, extent, up } = manifest;
    const { width, height, fx, near } = view.camera;
    const depth = project(center, view.pose, view.camera)[2];
    const side = (FIRST_SIDE * Math.min(width, height) * (depth > near ? depth : extent)) / fx;
    return uprightBox(center, side, up, row(view.pose.rotation, 2));
  }

  /** Forget the box: another scene has another world. */
  #forget(): void {
    if (this.active) this.toggle();
    this.#box = null;
    this.#application.forget();
  }

  #change(box: CropBox | null): void {
    if (box) this.#box = box;
    this.#draw();
  }

  #grab(handle: Handle, event: PointerEvent, group: SVGElement): void {
    const view = this.#view();
    const box = this.#box;
    if (!view || !box || event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    group.setPointerCapture(event.pointerId);
    group.classList.add("crop-held");
    const { left, top } = this.root.getBoundingClientRect();
    const at = ({ clientX, clientY }: PointerEvent): Pixel => [clientX - left, clientY - top];
    const from = at(event);
    const held = new AbortController();
    const { signal } = held;
    group.addEventListener(
      "pointermove",
      (moved) => this.#change(dragged(handle, box, from, at(moved as PointerEvent), view)),
      { signal },
    );
    const release = () => {
      held.abort();
      group.classList.remove("crop-held");
    };
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) {
      group.addEventListener(type, release, { signal });
    }
  }

  #view() {
    return cropViewOf(this.player, this.root.getBoundingClientRect());
  }

  #drawSoon(): void {
    if (!this.active || this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #draw(): void {
    const view = this.#view();
    if (!this.active || !view || !this.#box) return;
    this.#drawing.show(this.#box, this.#inverse, view);
    const wish: CropWish = { box: this.#box, inverse: this.#inverse, trim: this.player.loopRange };
    this.#panel.show(wish, this.player.start);
    const asked = documentFor(wish);
    if (asked === this.#document) return;
    this.#document = asked;
    this.#application.ready = true;
    this.#application.changed();
  }
}
