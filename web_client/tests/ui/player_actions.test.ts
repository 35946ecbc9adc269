import { beforeEach, describe, expect, it, vi } from "vitest";
import type { FlyMode } from "../../src/camera/fly_mode";
import type { HgsPlayer } from "../../src/player/hgs_player";
import { longSeekStep, PlayerActions, pictureName, rateAfter, seekStep } from "../../src/ui/player_actions";
import { manifest } from "../scene";

it("goes five and ten seconds at a time, in a short scene a tenth and a fifth of it", () => {
  expect([seekStep(60), longSeekStep(60)]).toEqual([5, 10]);
  expect([seekStep(2), longSeekStep(2)]).toEqual([0.2, 0.4]);
});

it.each([
  [1, 1, 1.25],
  [1, -1, 0.75],
  [2, 1, 2],
  [0.25, -1, 0.25],
  [3, -1, 2], // a rate that the page has set
] as const)("after a rate of %s %s step goes to %s", (rate, steps, next) => {
  expect(rateAfter(rate, steps)).toBe(next);
});

describe("a scene from 1 to 11 seconds", () => {
  let player: { start: number; end: number; duration: number; currentTime: number; loopRange: unknown } & Partial<
    Pick<HgsPlayer, "subjectOnly">
  >;
  let actions: PlayerActions;
  const notify = vi.fn();
  const fail = vi.fn();
  const keep = vi.fn();

  beforeEach(() => {
    notify.mockClear();
    fail.mockClear();
    player = { start: 1, end: 11, duration: 10, currentTime: 4, loopRange: null };
    actions = new PlayerActions(player as unknown as HgsPlayer, {
      fly: {} as FlyMode,
      bookmarks: { times: [] },
      keep,
      notify,
      fail,
      changed: () => {},
      link: ({ time, subjectOnly }) => `https://a.example/?t=${time}&subject=${subjectOnly}`,
      toggleCrop: null,
      togglePath: null,
      toggleClean: null,
    });
  });

  it("is not left by seeking", () => {
    actions.seekBy(-5);
    expect(player.currentTime).toBe(1);
    actions.seekBy(50);
    expect(player.currentTime).toBe(11);
    actions.jump(0.3);
    expect(player.currentTime).toBe(4);
    expect(notify).toHaveBeenLastCalledWith("0:03.00"); // as the bar counts
  });

  it("repeats from one key's place to the other's, to the end while there is only one", () => {
    actions.setLoop("from");
    expect(player.loopRange).toEqual([4, 11]);
    player.currentTime = 6;
    actions.setLoop("to");
    expect(player.loopRange).toEqual([4, 6]);
    player.currentTime = 8;
    actions.setLoop("from"); // behind its end: a new stretch
    expect(player.loopRange).toEqual([8, 11]);
    actions.clearLoop();
    expect(player.loopRange).toBeNull();
  });

  it("refuses an empty stretch in words", () => {
    player.currentTime = 1;
    actions.setLoop("to");
    expect(player.loopRange).toBeNull();
    expect(notify).toHaveBeenCalledWith(expect.stringContaining("must start before"));
  });

  it("goes from bookmark to bookmark", () => {
    actions.toggleBookmark();
    expect(keep).toHaveBeenLastCalledWith([4]);
    player.currentTime = 9;
    actions.goToBookmark(-1);
    expect(player.currentTime).toBe(4);
    actions.goToBookmark(1);
    expect(player.currentTime).toBe(4);
    expect(notify).toHaveBeenLastCalledWith("No later bookmark");
  });

  it("is shown without what stands still, if it has something else, too", () => {
    const totals = { splatsStatic: 5, splatsDynamic: 0, bytesStatic: 0, bytesDynamic: 0 };
    player.subjectOnly = false;
    actions.toggleSubjectOnly();
    Object.assign(player, { manifest: manifest({ totals }) });
    actions.toggleSubjectOnly();
    expect(player.subjectOnly).toBe(false);
    Object.assign(player, { manifest: manifest({ totals: { ...totals, splatsDynamic: 1 } }) });
    actions.toggleSubjectOnly();
    expect(player.subjectOnly).toBe(true);
    actions.toggleSubjectOnly();
    expect(player.subjectOnly).toBe(false);
  });

  it("shows the link where the browser does not let the page copy", async () => {
    vi.stubGlobal("navigator", { clipboard: undefined });
    Object.assign(player, { camera: { name: "side", view: null } });
    await actions.copyLink();
    expect(fail).toHaveBeenCalledWith(expect.stringContaining("https://a.example/?t=4"));
    vi.unstubAllGlobals();
  });

  it("has what stands still in its link only where that is not the scene's own choice", async () => {
    vi.stubGlobal("navigator", { clipboard: undefined });
    Object.assign(player, { camera: { name: "side", view: null } });
    const linked = async (own: boolean, shown: boolean) => {
      const capturedSpace = { front: [1, 0, 0], azimuth: null, elevation: [-1, 1], distance: [1, 9] } as const;
      Object.assign(player, {
        subjectOnly: shown,
        manifest: manifest({ capturedSpace: { ...capturedSpace, subjectOnly: own } }),
      });
      await actions.copyLink();
      return /subject=(.*)/.exec(fail.mock.lastCall?.[0])?.[1];
    };
    expect([await linked(true, true), await linked(true, false), await linked(false, true)]).toEqual([
      "null",
      "false",
      "true",
    ]);
    vi.unstubAllGlobals();
  });
});

it.each([
  ["studio", 1.2, "studio 0m01.20s.png"],
  ["Küche: a/b?", 61.005, "Küche a b 1m01.01s.png"],
  ["", 0, "scene 0m00.00s.png"],
])("names a picture of %j at %s s %j", (title, time, name) => {
  expect(pictureName(title, time)).toBe(name);
});
