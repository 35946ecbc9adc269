/**
 * Frames on demand: nothing that a page asks `requestAnimationFrame` for runs until `pump` is called. Imported before any
 * viewer, which may keep the function; and every context is made without multisampling, so that all draw alike.
 */

let waiting: FrameRequestCallback[] = [];
let last = 0;

window.requestAnimationFrame = (callback) => {
  waiting.push(callback);
  return ++last;
};

const getContext = HTMLCanvasElement.prototype.getContext as (
  this: HTMLCanvasElement,
  type: string,
  options?: object,
) => RenderingContext | null;
HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, type: string, options?: object) {
  return getContext.call(this, type, type === "webgl2" ? { ...options, antialias: false } : options);
} as typeof HTMLCanvasElement.prototype.getContext;

/** Run what was asked for. */
export function pump(): void {
  const callbacks = waiting;
  waiting = [];
  const now = performance.now();
  for (const callback of callbacks) callback(now);
}
