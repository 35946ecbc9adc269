import { beforeEach, expect, it } from "vitest";
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

let pace: GpuPace;

function draw(times: number, duration: number, quick = false): void {
  for (let i = 0; i < times; i++) {
    pace.submitted(1000 * i, quick);
    pace.busy(1000 * i + duration);
  }
}

beforeEach(() => {
  done = true;
  pace = new GpuPace(context as unknown as WebGL2RenderingContext);
});

it("is busy until the picture is done", () => {
  done = false;
  pace.submitted(0, false);
  expect(pace.busy(10)).toBe(true);
  done = true;
  expect(pace.busy(20)).toBe(false);
});

it("finds a device slow after several slow pictures in a row", () => {
  draw(3, 200);
  expect(pace.slow).toBe(false);
  draw(1, 200);
  expect(pace.slow).toBe(true);
});

it("judges by fine pictures alone", () => {
  draw(4, 200);
  draw(9, 10, true);
  expect(pace.slow).toBe(true);
  draw(1, 10);
  expect(pace.slow).toBe(false);
});
