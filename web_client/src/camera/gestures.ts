/** Gestures: pointer, wheel and touch on the picture, as camera motions and taps. */

export interface CameraMotion {
  /** Radians. */
  turn(yaw: number, pitch: number): void;
  /** Factor of the distance. */
  zoom(factor: number): void;
  /** CSS pixels. */
  pan(dx: number, dy: number): void;
  /** The end of a motion, or of a single step. */
  release(): void;
  /** Look at the scene's point at a place of the picture, CSS pixels from its top left corner. */
  focus(x: number, y: number): void;
}

const TURN = 0.006; // radians per CSS pixel
const WHEEL_LINE = 20; // CSS pixels per line of a wheel that counts lines
/** Largest movement of a tap, CSS pixels; more is a drag. */
const SLACK = { mouse: 4, finger: 10 };
/** Longest pause in a double tap, milliseconds; a single tap waits as long. */
const DOUBLE_TAP = 250;

interface Point {
  x: number;
  y: number;
}

export interface GestureOptions {
  /** Whether the wheel zooms now; otherwise it scrolls the page. */
  readonly wheelZooms: () => boolean;
  /** A single tap or click; a double one moves the camera instead. */
  readonly onTap: () => void;
}

/** Listen to pointers on `target` until `signal` aborts. */
export function listenForGestures(
  target: HTMLElement,
  motion: CameraMotion,
  { wheelZooms, onTap }: GestureOptions,
  signal: AbortSignal,
): void {
  const pointers = new Map<number, Point>();
  let panning = false;
  let resting: Point | null = null; // start of the only pointer, while it may become a tap
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
      motion.pan(dx / 2, dy / 2); // motion of the middle of the two fingers
    } else if (panning) {
      motion.pan(dx, dy);
    } else {
      motion.turn(dx * TURN, dy * TURN);
    }
    pointers.set(id, to);
  };

  const tap = ({ clientX, clientY }: PointerEvent): void => {
    const second = firstTap !== undefined;
    clearTimeout(firstTap);
    firstTap = undefined;
    if (second) {
      const { left, top } = target.getBoundingClientRect();
      motion.focus(clientX - left, clientY - top);
      return;
    }
    firstTap = setTimeout(() => {
      firstTap = undefined;
      onTap();
    }, DOUBLE_TAP);
  };

  /** A drag begins where the pointer leaves the slack, so that the picture does not jump. */
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
    const known = pointers.delete(event.pointerId);
    const tapped = known && resting !== null && event.type === "pointerup";
    resting = null;
    if (tapped) tap(event);
    else if (known && pointers.size === 0) motion.release();
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
      motion.release();
    },
    { signal, passive: false },
  );
}
