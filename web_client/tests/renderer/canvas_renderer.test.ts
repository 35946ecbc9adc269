import { describe, expect, it, vi } from "vitest";
import { CanvasRenderer } from "../../src/renderer/canvas_renderer";

/** A context that accepts every call; uniforms are known by name. */
function fakeCanvas(uniform1i: (location: string, value: number) => void): HTMLCanvasElement {
  const calls: Record<string, unknown> = {
    uniform1i,
    getExtension: () => null,
    getProgramParameter: () => true,
    getUniformLocation: (_: unknown, name: string) => name,
  };
  const canvas: Record<string, unknown> = { width: 1, height: 1, addEventListener: () => {} };
  const context = new Proxy({ canvas } as Record<string, unknown>, {
    get: (own, name: string) => own[name] ?? calls[name] ?? (/^[A-Z]/.test(name) ? 1 : () => ({})),
  });
  canvas.getContext = () => context;
  return canvas as unknown as HTMLCanvasElement;
}

describe("CanvasRenderer", () => {
  it.each([true, false])("tells the shader of each picture whether it is antialiased: %s", (antialiased) => {
    const uniform1i = vi.fn();
    const renderer = new CanvasRenderer(fakeCanvas(uniform1i), () => {});
    renderer.splats.setOrder(new Uint32Array(2048), 1);
    const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
    const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
    renderer.draw({ pose, camera, time: 0, antialiased });
    expect(uniform1i).toHaveBeenCalledWith("antialiased", antialiased ? 1 : 0);
  });
});
