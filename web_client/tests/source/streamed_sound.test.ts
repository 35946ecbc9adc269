import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { StreamedSound } from "../../src/source/streamed_sound";

const BYTES = Uint8Array.of(1, 2, 3);

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function sound() {
  const changed = vi.fn();
  return { changed, sound: new StreamedSound(new Set(["a", "b", "c"]), changed) };
}

describe("StreamedSound", () => {
  it("wants sound from the first question on, and brings what comes", async () => {
    const { sound: streamed, changed } = sound();
    expect(streamed.wanted).toBe(false);
    const asked = streamed.ask("a");
    expect([streamed.wanted, changed.mock.calls.length]).toEqual([true, 1]);
    streamed.arrived("a", BYTES);
    expect(await asked).toBe(BYTES);
  });

  it("keeps what comes before it is asked for, and gives it once", async () => {
    const { sound: streamed } = sound();
    streamed.arrived("b", BYTES);
    expect(await streamed.ask("b")).toBe(BYTES);
    expect(await streamed.ask("b")).toBeNull(); // the server sends it no more
    expect(streamed.sent).toEqual(["b"]);
  });

  it("leaves other chunks, and all after the end, to others", async () => {
    const { sound: streamed } = sound();
    expect(await streamed.ask("other")).toBeNull();
    expect(streamed.wanted).toBe(false);
    const asked = streamed.ask("a");
    streamed.end();
    expect(await asked).toBeNull();
    expect(await streamed.ask("b")).toBeNull();
  });

  it("says when nobody has asked for long", async () => {
    const { sound: streamed, changed } = sound();
    streamed.arrived("a", BYTES);
    await streamed.ask("a");
    vi.advanceTimersByTime(11_000);
    expect([streamed.wanted, changed.mock.calls.length]).toEqual([false, 2]);
  });

  it("does not wait for a server that sends none", async () => {
    const { sound: streamed } = sound();
    const asked = streamed.ask("a");
    vi.advanceTimersByTime(4000);
    expect(await asked).toBeNull();
    expect(await streamed.ask("b")).toBeNull(); // at once
  });

  it("goes on without a piece that the server cannot give", async () => {
    const { sound: streamed } = sound();
    const asked = streamed.ask("a");
    streamed.missing("a");
    expect(await asked).toBeNull();
  });
});
