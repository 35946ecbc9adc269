import { expect, it, vi } from "vitest";
import { openLate } from "../../src/source/late_source";
import type { OpenSource, SceneSource } from "../../src/source/scene_source";

const PLAYHEAD = { time: 1.5, rate: 1 };

function opened() {
  const events = {
    manifest() {},
    grown() {},
    chunk() {},
    missing() {},
    progress() {},
    state: vi.fn(),
    failed: vi.fn(),
  };
  const source = { seek: vi.fn(), wake: vi.fn(), close: vi.fn(), fetchAgain: vi.fn(async () => new Uint8Array(3)) };
  const open = vi.fn<OpenSource>(() => source as unknown as SceneSource);
  let arrive: (open: OpenSource) => void = () => {};
  let fail: (error: Error) => void = () => {};
  const module = new Promise<OpenSource>((resolve, reject) => {
    arrive = resolve;
    fail = reject;
  });
  const late = openLate(() => module)(events, PLAYHEAD);
  return { events, source, open, arrive, fail, late };
}

it("opens its source when the module has come, and hands on what is asked of it", async () => {
  const { events, source, open, arrive, late } = opened();
  late.wake();
  expect(events.state.mock.calls).toEqual([["connecting"]]);
  arrive(open);
  await vi.waitUntil(() => open.mock.calls.length > 0);
  expect(open).toHaveBeenCalledExactlyOnceWith(events, PLAYHEAD);
  late.seek(2);
  expect(source.seek).toHaveBeenCalledExactlyOnceWith(2);
  late.close();
  expect(source.close).toHaveBeenCalledOnce();
  const { signal } = new AbortController();
  expect(await late.fetchAgain("a", signal, "default")).toHaveLength(3);
  expect(source.fetchAgain).toHaveBeenCalledExactlyOnceWith("a", signal, "default");
});

it("opens nothing if it has been closed by then", async () => {
  const { events, open, arrive, late } = opened();
  late.close();
  arrive(open);
  await expect(late.fetchAgain("a", new AbortController().signal)).rejects.toThrow("closed before");
  expect(open).not.toHaveBeenCalled();
  expect(events.state).toHaveBeenLastCalledWith("closed");
  expect(events.failed).not.toHaveBeenCalled();
});

it("says that its module cannot be had", async () => {
  const { events, fail } = opened();
  fail(new TypeError("Failed to fetch"));
  await vi.waitUntil(() => events.failed.mock.calls.length > 0);
  expect(events.failed).toHaveBeenCalledExactlyOnceWith("not-loaded", "Failed to fetch");
  expect(events.state).toHaveBeenLastCalledWith("closed");
});
