/** The picture of the panel, painted again only when something on it has changed. */

import { BAR, CONTROLS, type Control, PIXELS, type Rectangle } from "./panel_layout";

export interface PanelState {
  readonly playing: boolean;
  /** Whether anything moves in the scene. */
  readonly moves: boolean;
  /** Share of the scene's duration, 0 to 1. */
  readonly share: number;
  /** "0:01.2 / 0:10.0" */
  readonly time: string;
  /** Whether the scene is muted; null if it has no sound. */
  readonly muted: boolean | null;
  /** Whether the scene is out of sight. */
  readonly lost: boolean;
  /** The control under a hand's pointer. */
  readonly pointed: Control | null;
}

const LOST = ["The scene is out of sight.", "Follow the arrow, or press", "“Start again here”."];
const HINT = ["Grip or pinch: move the scene", "Both hands: resize it", "A or X: play · B or Y: leave"];

export class PanelPicture {
  readonly canvas = document.createElement("canvas");
  readonly #context: CanvasRenderingContext2D;
  #painted = "";

  constructor() {
    this.canvas.width = PIXELS.width;
    this.canvas.height = PIXELS.height;
    const context = this.canvas.getContext("2d");
    if (!context) throw new Error("this browser offers no 2D canvas for the controls in the headset");
    this.#context = context;
  }

  /** Paint the panel; returns whether the picture has changed. */
  paint(state: PanelState): boolean {
    const content = JSON.stringify({ ...state, share: Math.round(state.share * BAR.width) });
    if (content === this.#painted) return false;
    this.#painted = content;
    const c = this.#context;
    c.clearRect(0, 0, PIXELS.width, PIXELS.height);
    this.#box({ x: 2, y: 2, width: PIXELS.width - 4, height: PIXELS.height - 4 }, 40, "rgb(13 15 19 / 85%)");
    if (state.moves) {
      this.#playButton(state);
      this.#seekBar(state);
    }
    this.#textButton("reset", "Start again here", state);
    if (state.muted !== null) this.#textButton("mute", state.muted ? "Unmute" : "Mute", state);
    this.#textButton("leave", "Leave", state);
    c.fillStyle = "#9aa3b2";
    c.font = "24px system-ui, sans-serif";
    c.textAlign = "center";
    (state.lost ? LOST : HINT).forEach((line, i) => {
      c.fillText(line, PIXELS.width / 2, 202 + 34 * i);
    });
    return true;
  }

  #playButton({ playing, pointed }: PanelState): void {
    const { x, y, width, height } = CONTROLS.play;
    this.#box(CONTROLS.play, width / 2, pointed === "play" ? "#4c8dff" : "#262b35");
    const c = this.#context;
    c.fillStyle = "#fff";
    const [middleX, middleY] = [x + width / 2, y + height / 2];
    if (playing) {
      c.fillRect(middleX - 26, middleY - 30, 18, 60);
      c.fillRect(middleX + 8, middleY - 30, 18, 60);
      return;
    }
    c.beginPath();
    c.moveTo(middleX - 20, middleY - 34);
    c.lineTo(middleX - 20, middleY + 34);
    c.lineTo(middleX + 36, middleY);
    c.fill();
  }

  #seekBar({ share, time, pointed }: PanelState): void {
    const c = this.#context;
    this.#box(BAR, BAR.height / 2, "#3a4150");
    const played = share * BAR.width;
    this.#box({ ...BAR, width: Math.max(BAR.height, played) }, BAR.height / 2, "#4c8dff");
    c.fillStyle = "#fff";
    c.beginPath();
    c.arc(BAR.x + played, BAR.y + BAR.height / 2, pointed === "seek" ? 26 : 18, 0, 2 * Math.PI);
    c.fill();
    c.font = "36px system-ui, sans-serif";
    c.textAlign = "right";
    c.textBaseline = "middle";
    c.fillText(time, BAR.x + BAR.width, 128);
  }

  #textButton(control: Control, text: string, { pointed }: PanelState): void {
    const { x, y, width, height } = CONTROLS[control];
    this.#box(CONTROLS[control], 20, pointed === control ? "#4c8dff" : "#262b35");
    const c = this.#context;
    c.fillStyle = "#fff";
    c.font = "32px system-ui, sans-serif";
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillText(text, x + width / 2, y + height / 2);
  }

  #box({ x, y, width, height }: Rectangle, radius: number, colour: string): void {
    const c = this.#context;
    c.fillStyle = colour;
    c.beginPath();
    c.roundRect(x, y, width, height, radius);
    c.fill();
  }
}
