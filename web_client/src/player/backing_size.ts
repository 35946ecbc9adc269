/** The pixels for a sharp canvas: its size on the screen, which depends on window, zoom and monitor. */

/** Backing pixels per CSS pixel beyond which splats gain no sharpness. */
const SHARPEST = 2;

interface Size {
  readonly width: number;
  readonly height: number;
}

/**
 * The backing store of a canvas of that size in CSS pixels on a screen of `ratio` device pixels each.
 *
 * `device` is its size in device pixels, rounded by the browser as no page can; null in browsers that do not report it.
 */
export function backingSize(css: Size, device: Size | null, ratio: number): Size {
  const scale = Math.min(SHARPEST, ratio);
  const side = (length: number, rounded: number | undefined): number => {
    const exact = length * scale;
    // Otherwise it belongs to an earlier ratio, or exceeds the useful number of pixels.
    const right = rounded !== undefined && Math.abs(rounded - exact) < 1;
    return Math.max(1, right ? rounded : Math.round(exact));
  };
  return { width: side(css.width, device?.width), height: side(css.height, device?.height) };
}

/** Call `onSize` with the size of the backing store, now and at every change until `signal` aborts. */
export function observeBackingSize(canvas: HTMLCanvasElement, onSize: (size: Size) => void, signal: AbortSignal): void {
  let css: Size = { width: 0, height: 0 };
  let device: Size | null = null;
  const report = () => onSize(backingSize(css, device, devicePixelRatio));
  const observer = new ResizeObserver(([entry]) => {
    css = entry.contentRect;
    const [box] = entry.devicePixelContentBoxSize ?? [];
    device = box ? { width: box.inlineSize, height: box.blockSize } : null;
    report();
  });
  try {
    observer.observe(canvas, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(canvas); // Safari reports no device pixels
  }
  signal.addEventListener("abort", () => observer.disconnect());
  followRatio(report, signal);
}

/** Call `onChange` whenever the device pixel ratio changes, for example on another monitor or by the browser's zoom. */
function followRatio(onChange: () => void, signal: AbortSignal): void {
  const changed = () => {
    onChange();
    followRatio(onChange, signal); // each query is about one ratio
  };
  matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", changed, { once: true, signal });
}
