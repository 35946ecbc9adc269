import { describe, expect, it, vi } from "vitest";
import { HostSound } from "../../src/host/host_sound";

const made = (options = {}) => {
  const events = { changed: vi.fn(), failed: vi.fn() };
  const scene = { manifest: null, playback: null, source: {} as never };
  return { events, sound: new HostSound(options, scene, new AbortController().signal, events) };
};

describe("the sound of a host's scene", () => {
  it("begins as loud as it was asked for", () => {
    const { sound } = made();
    expect([sound.muted, sound.volume]).toEqual([false, 1]);
    const { sound: other } = made({ muted: true, volume: 7 });
    expect([other.muted, other.volume]).toEqual([true, 1]);
  });

  it("tells the host and what plays it that it is to be louder or silent", () => {
    const { events, sound } = made();
    const heard = vi.fn();
    sound.addEventListener("volumechange", heard);
    sound.muted = true;
    sound.volume = -2;
    expect([sound.muted, sound.volume]).toEqual([true, 0]);
    expect([events.changed, heard].map((call) => call.mock.calls.length)).toEqual([2, 2]);
  });

  it("tells the host what went wrong", () => {
    const { events, sound } = made();
    const detail = { message: "This browser cannot play the scene's sound.", cause: "opus" };
    sound.dispatchEvent(new CustomEvent("error", { detail }));
    expect(events.failed).toHaveBeenCalledWith(detail);
  });
});
