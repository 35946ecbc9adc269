/** Flying: keys carry the camera through the scene, and dragging looks around, until it is switched off again. */

import { MotionLoop } from "./motion_loop";

/** What is flown. */
export interface Flight {
  /** To the right, upwards and ahead, as shares of the distance at which the camera began. */
  travel(right: number, up: number, ahead: number): void;
  /** The keys have been let go. */
  release(): void;
}

const SPEED = 0.5; // distances at which the camera began, per second
const FASTER = 3; // with the shift key

/** By where keys lie, not by what is written on them: the same on every keyboard. */
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

  /** @param keys where the player's keys are heard. */
  constructor(
    keys: EventTarget,
    readonly flight: Flight,
    signal: AbortSignal,
  ) {
    this.#loop = new MotionLoop(signal);
    keys.addEventListener("keydown", (event) => this.#press(event as KeyboardEvent), { signal });
    addEventListener("keyup", (event) => this.#lift(event), { signal }); // wherever the focus is by then
    addEventListener("blur", () => this.#held.clear(), { signal });
  }

  get active(): boolean {
    return this.#active;
  }

  toggle(): void {
    this.#active = !this.#active;
    this.#held.clear();
  }

  /** Whether a key flies now, and so does nothing else. */
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
