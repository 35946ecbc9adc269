import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { toggleFullscreen } from "../../src/ui/full_screen";

const requestFullscreen = vi.fn<() => Promise<void>>();
const root = { fullscreenElement: null as unknown };
const host = { requestFullscreen, getRootNode: () => root } as unknown as HTMLElement;
const page = { fullscreenEnabled: true, exitFullscreen: vi.fn<() => Promise<void>>() };

beforeEach(() => {
  requestFullscreen.mockReset().mockResolvedValue();
  page.exitFullscreen.mockReset().mockResolvedValue();
  page.fullscreenEnabled = true;
  root.fullscreenElement = null;
  vi.stubGlobal("document", page);
  vi.stubGlobal("window", { parent: "itself" });
});
afterEach(() => vi.unstubAllGlobals());

it("fills the screen with the player and gives it back", async () => {
  await toggleFullscreen(host);
  expect(requestFullscreen).toHaveBeenCalledOnce();
  root.fullscreenElement = host;
  await toggleFullscreen(host);
  expect(page.exitFullscreen).toHaveBeenCalledOnce();
  expect(requestFullscreen).toHaveBeenCalledOnce();
});

it("says that the frame around the page does not allow it, or that the browser does not", async () => {
  page.fullscreenEnabled = false;
  await expect(toggleFullscreen(host)).rejects.toThrow('needs allow="fullscreen"');
  const window = {} as { parent: unknown };
  window.parent = window;
  vi.stubGlobal("window", window);
  await expect(toggleFullscreen(host)).rejects.toThrow("This browser does not support full screen.");
});

it("says what the browser waits for", async () => {
  requestFullscreen.mockRejectedValue(new TypeError("not granted"));
  await expect(toggleFullscreen(host)).rejects.toThrow("right after a click or a key");
});
