import { describe, expect, it, vi } from "vitest";
import { CanvasRenderer } from "../../src/renderer/canvas_renderer";
import { fakeCanvas } from "../canvas";

describe("CanvasRenderer", () => {
  it.each([true, false])("tells the shader of each picture whether it is antialiased: %s", (antialiased) => {
    const uniform1i = vi.fn();
    const renderer = new CanvasRenderer(fakeCanvas({ uniform1i }), () => {});
    renderer.splats.setOrder(new Uint32Array(2048), 1);
    const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
    const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
    renderer.draw({ pose, camera, time: 0, antialiased, rig: [] }, 0);
    expect(uniform1i).toHaveBeenCalledWith("antialiased", antialiased ? 1 : 0);
  });

  it("tells the shader how much larger it shows things than the scene's pictures did", () => {
    const uniform4f = vi.fn();
    const renderer = new CanvasRenderer(fakeCanvas({ uniform4f }), () => {});
    renderer.splats.setOrder(new Uint32Array(2048), 1);
    const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
    const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
    const rig = [{ ...pose, focal: 2 }];
    renderer.draw({ pose, camera, time: 0, antialiased: true, rig }, 0);
    const told = uniform4f.mock.lastCall as [string, number, number, number, number];
    expect(told[0]).toBe("magnification");
    expect(told[3]).toBeCloseTo(2, 2);
  });

  it.each([
    [{ clear: 2, widest: 3 }, 2, 3],
    [{}, 0, 1e9],
  ])("tells the shader what fades before the eye: %o", (closeUp, clear, widest) => {
    const uniform2f = vi.fn();
    const renderer = new CanvasRenderer(fakeCanvas({ uniform2f }), () => {});
    renderer.splats.setOrder(new Uint32Array(2048), 1);
    const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
    const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
    renderer.draw({ pose, camera, time: 0, antialiased: true, rig: [], ...closeUp }, 0);
    expect(uniform2f).toHaveBeenCalledWith("closeUp", clear, widest);
  });
});
