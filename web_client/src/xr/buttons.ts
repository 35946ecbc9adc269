/** Thumbsticks and buttons of a controller, as events by purpose, one for every press. */

/** Indices of buttons in WebXR's gamepad mapping "xr-standard". */
const BUTTON = { lower: 4, upper: 5 }; // A or X, B or Y
const STICK = 2; // first of its two axes

const PUSHED = 0.7;
const BACK = 0.3; // position below which a stick counts again
const DEAD = 0.15;

export interface Presses {
  /** A or X was pressed. */
  readonly lower: boolean;
  /** B or Y was pressed. */
  readonly upper: boolean;
  /** The stick was pushed to the left (-1) or right (1). */
  readonly flick: -1 | 0 | 1;
  /** Position of the stick, left to right, -1 to 1; 0 at rest. */
  readonly stick: number;
}

export class Buttons {
  #lower = true; // held; a button that is down at first does not count as pressed
  #upper = true;
  #flicked = true;

  read({ buttons, axes }: Pick<Gamepad, "buttons" | "axes">): Presses {
    const lower = buttons[BUTTON.lower]?.pressed ?? false;
    const upper = buttons[BUTTON.upper]?.pressed ?? false;
    const x = axes[STICK] ?? 0;
    const flick = !this.#flicked && Math.abs(x) > PUSHED ? (Math.sign(x) as -1 | 1) : 0;
    if (flick !== 0) this.#flicked = true;
    else if (Math.abs(x) < BACK) this.#flicked = false;
    const presses = {
      lower: lower && !this.#lower,
      upper: upper && !this.#upper,
      flick,
      stick: Math.abs(x) > DEAD ? x : 0,
    } as const;
    this.#lower = lower;
    this.#upper = upper;
    return presses;
  }
}
