import { describe, expect, it, vi } from "vitest";
import type { Manifest } from "../../src/codec/types";
import { panelState, sceneCommands } from "../../src/xr/transport";

const player = (start: number, end: number, audio: unknown = undefined) => ({
  manifest: { audio } as Manifest,
  muted: true,
  volume: 1,
  start,
  end,
  currentTime: start,
  paused: true,
  play: vi.fn(function (this: { paused: boolean }) {
    this.paused = false;
  }),
  pause: vi.fn(function (this: { paused: boolean }) {
    this.paused = true;
  }),
});

describe("the playhead in a headset", () => {
  it("is shown with its time and share", () => {
    const at = player(10, 80);
    at.currentTime = 75.25;
    expect(panelState(at, null)).toMatchObject({ moves: true, playing: false, time: "1:05.3 / 1:10.0" });
    expect(panelState(at, null).share).toBeCloseTo(65.25 / 70, 12);
  });

  it.each([true, false])("is shown with whether the scene is out of sight: %s", (lost) => {
    expect(panelState(player(10, 80), null, lost).lost).toBe(lost);
    expect(panelState(player(0, 0), null, lost).lost).toBe(lost);
  });

  it("is not shown in a still scene, nor before the scene is there", () => {
    expect(panelState(player(0, 0), null).moves).toBe(false);
    expect(panelState(player(0, Number.NaN), null).moves).toBe(false);
  });

  it("has a sound that a button mutes, where the scene has any", () => {
    const at = player(0, 10, {});
    expect(panelState(at, null).muted).toBe(true);
    sceneCommands(at).toggleMuted();
    expect([at.muted, panelState(at, null).muted]).toEqual([false, false]);
    at.volume = 0; // turned down on the page
    expect(panelState(at, null).muted).toBe(true);
    sceneCommands(at).toggleMuted();
    expect([at.muted, at.volume]).toEqual([false, 0.5]);
  });

  it("has no button for sound where there is none", () => {
    const at = player(0, 10);
    sceneCommands(at).toggleMuted();
    expect([at.muted, panelState(at, null).muted]).toEqual([true, null]);
  });

  it("goes to a share of the scene, and on by one, and plays and pauses", () => {
    const at = player(10, 30);
    const commands = sceneCommands(at);
    commands.seek(0.5);
    expect(at.currentTime).toBe(20);
    commands.scrub(-0.25);
    expect(at.currentTime).toBe(15);
    commands.togglePlay();
    commands.togglePlay();
    expect([at.play, at.pause].map((call) => call.mock.calls.length)).toEqual([1, 1]);
  });
});
