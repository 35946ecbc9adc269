/** A canvas whose WebGL2 context accepts every call; uniforms are known by name. */
export function fakeCanvas(more: Record<string, unknown> = {}): HTMLCanvasElement {
  const calls: Record<string, unknown> = {
    getExtension: () => null,
    isContextLost: () => false,
    getParameter: () => 16384,
    getProgramParameter: () => true,
    getUniformLocation: (_: unknown, name: string) => name,
    ...more,
  };
  const canvas: Record<string, unknown> = { width: 1, height: 1, addEventListener: () => {} };
  const context = new Proxy({ canvas } as Record<string, unknown>, {
    get: (own, name: string) => own[name] ?? calls[name] ?? (/^[A-Z]/.test(name) ? 1 : () => ({})),
  });
  canvas.getContext = () => context;
  return canvas as unknown as HTMLCanvasElement;
}
