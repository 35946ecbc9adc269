import { expect, it, vi } from "vitest";
import { GpuPace } from "../../src/renderer/gpu_pace";

let done = true;

/** As much of a graphics context as fences need. */
const context = {
  SYNC_GPU_COMMANDS_COMPLETE: 1,
  TIMEOUT_EXPIRED: 2,
  CONDITION_SATISFIED: 3,
  fenceSync: () => ({}),
  deleteSync: () => {},
  flush: () => {},
  clientWaitSync: () => (done ? context.CONDITION_SATISFIED : context.TIMEOUT_EXPIRED),
};

it("is busy until the picture is done, and then tells how long it took", () => {
  const measured = vi.fn();
  const pace = new GpuPace(context as unknown as WebGL2RenderingContext, measured);
  done = false;
  pace.submitted(100, 2);
  expect(pace.busy(110)).toBe(true);
  expect(measured).not.toHaveBeenCalled();
  done = true;
  expect(pace.busy(140)).toBe(false);
  expect(pace.busy(150)).toBe(false);
  expect(measured).toHaveBeenCalledExactlyOnceWith(40, 2);
});
