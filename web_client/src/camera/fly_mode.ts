/** Flying: keys move the camera through the scene, and drags look around, until it is switched off. */

import { MotionLoop } from "./motion_loop";

/** A camera that can fly. */
export interface Flight {
  /** To the right, upwards and ahead, as shares of the camera's first distance. */
  travel(right: number, up: number, ahead: number): void;
  /** All keys have been released. */
  release(): void;
}

const SPEED = 0.5; // first distances per second
const FASTER = 3; // factor with the shift key

/** Codes of key positions, not of letters: the same on every keyboard. */
const DIRECTIONS: Readonly<Record<string, readonly [number, number, number]>> = {
  KeyW: [0, 0, 1],
  KeyS: [0, 0, -1],
  KeyA: [-1, 0, 0],
  KeyD: [1, 0, 0],
  KeyE: [0, 1, 0],
  KeyQ: [0, -1, 0],
};

export class FlyMode {
  #active = false;
  #fast = false;
  readonly #held = new Set<string>();
  readonly #loop: MotionLoop;

  /** @param keys target of the player's key events. */
  constructor(
    keys: EventTarget,
    readonly flight: Flight,
    signal: AbortSignal,
  ) {
    this.#loop = new MotionLoop(signal);
    keys.addEventListener("keydown", (event) => this.#press(event as KeyboardEvent), { signal });
    addEventListener("keyup", (event) => this.#lift(event), { signal }); // the focus may have moved meanwhile
    addEventListener("blur", () => this.#held.clear(), { signal });
  }

  get active(): boolean {
    return this.#active;
  }

  toggle(): void {
    this.#active = !this.#active;
    this.#held.clear();
  }

  /** Whether a key is used for flying now, and for nothing else. */
  uses({ code, ctrlKey, metaKey, altKey }: KeyboardEvent): boolean {
    return this.#active && code in DIRECTIONS && !ctrlKey && !metaKey && !altKey;
  }

  #press(event: KeyboardEvent): void {
    this.#fast = event.shiftKey;
    if (event.defaultPrevented || !this.uses(event)) return;
    event.preventDefault();
    this.#held.add(event.code);
    if (!this.#loop.running) this.#loop.run((seconds) => this.#fly(seconds));
  }

  #lift(event: KeyboardEvent): void {
    this.#fast = event.shiftKey;
    this.#held.delete(event.code);
  }

  #fly(seconds: number): boolean {
    const way = SPEED * (this.#fast ? FASTER : 1) * seconds;
    const held = [...this.#held].map((code) => DIRECTIONS[code]);
    const sum = (axis: 0 | 1 | 2) => way * held.reduce((total, direction) => total + direction[axis], 0);
    if (held.length > 0) this.flight.travel(sum(0), sum(1), sum(2));
    else this.flight.release();
    return held.length > 0;
  }
}
