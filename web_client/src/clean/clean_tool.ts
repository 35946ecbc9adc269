/** The cleaning tool: visible splats are selected, hidden and deleted; the result is a list for `hgs edit`. */

import { resized } from "../camera/pinhole";
import { EditApplication, type StartEdit } from "../dom/edit_application";
import { element } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import toolCss from "../dom/tool_panel.css?inline";
import type { HgsPlayer } from "../player/hgs_player";
import { strokeArea } from "./areas";
import { ChunkLoader } from "./chunk_loader";
import css from "./clean.css?inline";
import { CleanPanel, type Hand } from "./clean_panel";
import { HandStrokes } from "./hand_strokes";
import { MarkedTextures } from "./marked_texels";
import { type Area, seenSplats } from "./seen_splats";
import { DELETED, HIDDEN, SELECTED, SplatMarks, splatList } from "./splat_marks";

/** The parts that live as long as one scene. */
interface Session {
  readonly loader: ChunkLoader;
  readonly marks: SplatMarks;
  readonly textures: MarkedTextures;
}

/** The name of the saved file. */
const FILE = "splats.json";

export class CleanTool {
  readonly #panel: CleanPanel;
  readonly #strokes: HandStrokes;
  readonly #application: EditApplication;
  #session: Session | null = null;
  #hand: Hand = "brush";
  #areas = 0; // areas that are not selected yet
  #last: Promise<void> = Promise.resolve(); // end of the last area's selection

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
    const change = (from: number, to: (mark: number) => number) => () => {
      const marks = this.#session?.marks;
      marks?.change(marks.places(from), to);
    };
    this.#application = new EditApplication(startEdit, () => splatList(this.#session?.marks.deleted() ?? {}));
    const events = {
      hand: (hand: Hand) => {
        this.#hand = hand;
        this.#show();
      },
      middle: () => {
        const { width, height } = root.getBoundingClientRect();
        this.#take(strokeArea([[width / 2, height / 2]], this.#panel.radius));
      },
      deselect: change(SELECTED, (mark) => mark & ~SELECTED),
      hide: change(SELECTED, (mark) => (mark & ~SELECTED) | HIDDEN),
      show: change(HIDDEN, (mark) => mark & ~HIDDEN),
      remove: change(SELECTED, deleted),
      undo: () => this.#session?.marks.undo(),
      redo: () => this.#session?.marks.redo(),
      save: () => this.#save(),
      close: () => this.toggle(),
    };
    this.#panel = new CleanPanel(events, this.#application.nodes);
    this.#strokes = new HandStrokes(root, {
      hand: () => (this.active ? this.#hand : "look"),
      radius: () => this.#panel.radius,
      begun: () => player.pause(),
      drawn: (area) => this.#take(area),
    });
    player.addEventListener("loadstart", () => this.#forget(), { signal });
    player.addEventListener("frame", () => this.active && this.#session?.textures.update(), { signal });
    addEventListener("keydown", (event) => this.active && this.#press(event), { signal, capture: true });
    signal.addEventListener("abort", () => this.#forget());
  }

  /** Whether the panel is shown. */
  get active(): boolean {
    return this.#panel.node.isConnected;
  }

  toggle(): void {
    if (this.active) {
      this.#leave();
      this.#session?.textures.clear();
      this.root.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
      return;
    }
    this.#session ??= this.#begin();
    if (!this.#session) return;
    this.root.querySelector(".stage")?.after(this.#strokes.node);
    this.root.append(this.#panel.node);
    this.#session.textures.update(this.#session.marks.ids);
    this.#show();
  }

  #begin(): Session | null {
    const { manifest, scene } = this.player;
    if (!manifest || !scene) return null;
    const loader = new ChunkLoader(manifest, scene);
    const marks = new SplatMarks(
      (id) => loader.sizeOf(id),
      (ids) => {
        textures.update(ids);
        this.#application.changed();
        this.#show();
      },
    );
    const textures = new MarkedTextures(scene, loader, marks, ({ message }) => this.#application.say(message));
    return { loader, marks, textures };
  }

  #leave(): void {
    this.#panel.node.remove();
    this.#strokes.node.remove();
    this.#show();
  }

  /** Forget all marks: another scene has other splats. */
  #forget(): void {
    this.#leave();
    this.#session?.loader.dispose();
    this.#session = null;
    this.#application.forget();
  }

  /** Select the splats seen in an area, CSS pixels, or take them from the selection; one area after the other. */
  #take(area: Area): void {
    const session = this.#session;
    const shot = this.player.scene?.shot;
    if (!session || !shot) return;
    const { takes, through } = this.#panel;
    const { width, height } = this.root.getBoundingClientRect();
    const camera = resized(shot.camera, width, height);
    const time = this.player.currentTime;
    const select = async ({ marks, loader }: Session): Promise<void> => {
      const of = (id: string) => marks.of(id);
      const chunks = await loader.shownAt(time, (id) => of(id) !== undefined);
      const seen = seenSplats(chunks, shot, camera, area, of, through);
      if (this.#session === session) marks.change(seen, (mark) => (takes ? mark & ~SELECTED : mark | SELECTED));
    };
    this.#areas++;
    this.#show();
    this.#last = this.#last
      .then(() => select(session))
      .catch(({ message }: Error) => this.#application.say(message))
      .finally(() => {
        this.#areas--;
        this.#show();
      });
  }

  #save(): void {
    if (!this.#session) return;
    const list = new Blob([splatList(this.#session.marks.deleted())], { type: "application/json" });
    const address = URL.createObjectURL(list);
    element("a", { href: address, download: FILE }).click();
    setTimeout(() => URL.revokeObjectURL(address), 60_000); // the browser may read it late
  }

  #show(): void {
    this.root.classList.toggle("cleaning", this.active && this.#hand !== "look");
    const marks = this.#session?.marks;
    if (!marks) return;
    this.#panel.show({
      hand: this.#hand,
      selected: marks.count(SELECTED, HIDDEN | DELETED),
      hidden: marks.count(HIDDEN, DELETED),
      deleted: marks.count(DELETED),
      canUndo: marks.canUndo,
      canRedo: marks.canRedo,
      busy: this.#areas > 0,
    });
    this.#application.ready = marks.count(DELETED) > 0;
  }

  /** The keys of the tool, ahead of the player's. */
  #press(event: KeyboardEvent): void {
    const marks = this.#session?.marks;
    const key = event.key.toLowerCase();
    const control = event.ctrlKey || event.metaKey;
    if (key === "escape" && this.root.querySelector("dialog[open], .menu:not([hidden])")) return;
    const remove = () => marks?.change(marks.places(SELECTED), deleted);
    const action = {
      z: control && (() => (event.shiftKey ? marks?.redo() : marks?.undo())),
      y: control && (() => marks?.redo()),
      delete: remove,
      backspace: remove,
      escape: () => this.toggle(),
    }[key];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }
}

const deleted = (mark: number): number => (mark & ~SELECTED) | DELETED;
