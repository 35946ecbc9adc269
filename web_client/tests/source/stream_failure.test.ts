import { readFileSync } from "node:fs";
import { afterEach, describe, expect, it, vi } from "vitest";
import { SOURCE_FAILURES } from "../../src/scene/source_failures";
import type { SourceFailure } from "../../src/source/scene_source";
import { SceneStream, streamFailure } from "../../src/source/scene_stream";
import { FakeSocket } from "../socket_double";

interface Closing {
  readonly code: number;
  readonly error: string | null;
  readonly retry: boolean;
}

const vectors = JSON.parse(readFileSync(new URL("../../../tests/vectors/messages.json", import.meta.url), "utf8"));
const closings = vectors.closing as Closing[];

/** What a stream says after the server has closed it with this code. */
function closedWith(code: number): { failed: ReturnType<typeof vi.fn>; sockets: FakeSocket[] } {
  vi.useFakeTimers();
  const sockets: FakeSocket[] = [];
  const nothing = () => {};
  const failed = vi.fn();
  const events = { manifest: nothing, grown: nothing, chunk: nothing, missing: nothing, progress: nothing };
  new SceneStream("ws://h/v1/scenes/s/stream", { ...events, state: nothing, failed }, { time: null, rate: 1 }, () => {
    sockets.push(new FakeSocket());
    return sockets[sockets.length - 1];
  });
  sockets[0].open();
  sockets[0].drop(code);
  vi.advanceTimersByTime(10_000);
  return { failed, sockets };
}

afterEach(() => vi.useRealTimers());

describe("every way in which a server closes a stream", () => {
  it.each(closings)("$code $error: is one that passes, or has a meaning and its words", ({ code, error, retry }) => {
    const { failed, sockets } = closedWith(code);
    expect(sockets.length > 1).toBe(retry);
    expect(failed).toHaveBeenCalledTimes(retry ? 0 : 1);
    if (retry) return;
    const failure = streamFailure(error ?? code) as Exclude<SourceFailure, "not-loaded">;
    expect(SOURCE_FAILURES[failure]).toMatch(/^[A-Z].*\.$/);
    expect(failure === "ended").toBe(error === "flood"); // all others say more
  });

  it.each([
    ["access-ended", 4003, "access-ended"],
    ["scene-not-found", 4004, "no-scene"],
    ["protocol-unsupported", 4001, "not-understood"],
    ["malformed", 4000, "not-understood"],
    ["credit-overflow", 4009, "not-understood"],
    ["message-too-large", 1009, "not-understood"],
    ["not-binary", 1003, "not-understood"],
  ])("%s is understood by its number, too", (error, code, meaning) => {
    expect([streamFailure(error), streamFailure(code)]).toEqual([meaning, meaning]);
  });

  it("tells a scene that is gone from one that another has replaced", () => {
    expect(streamFailure("scene-changed")).toBe("scene-changed");
  });

  it.each(["a code of tomorrow", "constructor", 4999])("%s: it has ended", (code) => {
    expect(streamFailure(code)).toBe("ended");
  });

  it("tells nobody whose access has ended to reload the page", () => {
    expect(SOURCE_FAILURES["access-ended"]).toMatch(/key or link .* no longer valid/);
    expect(SOURCE_FAILURES["access-ended"]).not.toMatch(/again|reload/i);
  });
});
