/** Pointer, wheel, touch and keys on the picture, as motions of an orbit camera and as taps. */

export interface CameraMotion {
  /** Radians. */
  turn(yaw: number, pitch: number): void;
  /** Factor of the distance. */
  zoom(factor: number): void;
  /** CSS pixels. */
  pan(dx: number, dy: number): void;
  reset(): void;
}

const TURN = 0.006; // radians per CSS pixel
const KEY_TURN = 0.06; // radians
const KEY_PAN = 24; // CSS pixels
const KEY_ZOOM = 1.1;
const WHEEL_LINE = 20; // CSS pixels of a wheel that counts lines
/** A pointer that has moved no farther than this is a tap and no drag, CSS pixels. */
const SLACK = { mouse: 4, finger: 10 };
/** A second tap within this makes a double tap, milliseconds; a single one waits as long. */
const DOUBLE_TAP = 250;

interface Point {
  x: number;
  y: number;
}

export interface GestureOptions {
  /** Where keys are heard: the window of a page that is a player alone, else an element that has the focus within. */
  readonly keys: EventTarget;
  /** Whether the wheel zooms now; if not, it scrolls the page. */
  readonly wheelZooms: () => boolean;
  /** A tap or click; a double one resets the camera and is no tap. */
  readonly onTap: () => void;
}

/** Listen until `signal` aborts: to pointers on `target`, and to keys that no control uses. */
export function listenForGestures(
  target: HTMLElement,
  motion: CameraMotion,
  { keys, wheelZooms, onTap }: GestureOptions,
  signal: AbortSignal,
): void {
  const pointers = new Map<number, Point>();
  let panning = false;
  let resting: Point | null = null; // where the only pointer went down, while it may become a tap
  let firstTap: ReturnType<typeof setTimeout> | undefined;

  const drag = (id: number, to: Point): void => {
    const from = pointers.get(id);
    if (!from) return;
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const other = [...pointers].find(([key]) => key !== id)?.[1];
    if (other) {
      const before = Math.hypot(from.x - other.x, from.y - other.y);
      const after = Math.hypot(to.x - other.x, to.y - other.y);
      if (before > 1 && after > 1) motion.zoom(before / after);
      motion.pan(dx / 2, dy / 2); // as far as the middle of the two fingers moves
    } else if (panning) {
      motion.pan(dx, dy);
    } else {
      motion.turn(dx * TURN, dy * TURN);
    }
    pointers.set(id, to);
  };

  const tap = (): void => {
    const second = firstTap !== undefined;
    clearTimeout(firstTap);
    firstTap = undefined;
    if (second) {
      motion.reset();
      return;
    }
    firstTap = setTimeout(() => {
      firstTap = undefined;
      onTap();
    }, DOUBLE_TAP);
  };

  /** A pointer that has rested begins its drag where it leaves the slack, so that the picture does not jump. */
  const move = (event: PointerEvent): void => {
    const to = { x: event.clientX, y: event.clientY };
    if (resting) {
      const slack = event.pointerType === "mouse" ? SLACK.mouse : SLACK.finger;
      const [dx, dy] = [to.x - resting.x, to.y - resting.y];
      const distance = Math.hypot(dx, dy);
      if (distance <= slack) return;
      const share = slack / distance;
      pointers.set(event.pointerId, { x: resting.x + dx * share, y: resting.y + dy * share });
      resting = null;
    }
    drag(event.pointerId, to);
  };

  target.addEventListener(
    "pointerdown",
    (event) => {
      if (pointers.size === 2) return;
      target.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      panning = event.button !== 0 || event.shiftKey;
      resting = pointers.size === 1 && !panning ? { x: event.clientX, y: event.clientY } : null;
    },
    { signal },
  );
  target.addEventListener("pointermove", move, { signal });
  const release = (event: PointerEvent): void => {
    if (pointers.delete(event.pointerId) && resting && event.type === "pointerup") tap();
    resting = null;
  };
  target.addEventListener("pointerup", release, { signal });
  target.addEventListener("pointercancel", release, { signal });
  signal.addEventListener("abort", () => clearTimeout(firstTap));
  target.addEventListener("contextmenu", (event) => event.preventDefault(), { signal }); // the right button pans
  target.addEventListener(
    "wheel",
    (event) => {
      if (!wheelZooms()) return;
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : WHEEL_LINE);
      // Browsers report a pinch on a touchpad as a wheel with Ctrl held, in much smaller steps.
      motion.zoom(Math.exp(Math.max(-200, Math.min(200, pixels)) * (event.ctrlKey ? 0.01 : 0.0015)));
    },
    { signal, passive: false },
  );
  listenForKeys(
    keys,
    (event, control) => {
      if (control instanceof HTMLInputElement || control instanceof HTMLSelectElement) return;
      if (press(event, motion)) event.preventDefault();
    },
    signal,
  );
}

/** Hear keys without modifiers on `target`, and which element they are for: also one inside a shadow root. */
export function listenForKeys(
  target: EventTarget,
  onKey: (event: KeyboardEvent, control: EventTarget) => void,
  signal: AbortSignal,
): void {
  const heard = (event: Event): void => {
    const { ctrlKey, metaKey, altKey } = event as KeyboardEvent;
    if (!ctrlKey && !metaKey && !altKey) onKey(event as KeyboardEvent, event.composedPath()[0]);
  };
  target.addEventListener("keydown", heard, { signal });
}

/** Returns whether the key moves the camera. */
function press(event: KeyboardEvent, motion: CameraMotion): boolean {
  const arrows: Readonly<Record<string, readonly [number, number]>> = {
    ArrowLeft: [1, 0],
    ArrowRight: [-1, 0],
    ArrowUp: [0, 1],
    ArrowDown: [0, -1],
  };
  const arrow = arrows[event.key];
  if (arrow && event.shiftKey) motion.pan(arrow[0] * KEY_PAN, arrow[1] * KEY_PAN);
  else if (arrow) motion.turn(arrow[0] * KEY_TURN, arrow[1] * KEY_TURN);
  else if (event.key === "+" || event.key === "=") motion.zoom(1 / KEY_ZOOM);
  else if (event.key === "-") motion.zoom(KEY_ZOOM);
  else if (event.key === "0" || event.key === "Home") motion.reset();
  else return false;
  return true;
}
