import { describe, expect, it } from "vitest";
import type { PlayerStats } from "../../src/player/player_types";
import type { NoticeKind } from "../../src/ui/notice_words";
import { noticeKind } from "../../src/ui/notices";
import { stats } from "../stats";

describe("noticeKind", () => {
  it.each<[NoticeKind, Partial<PlayerStats>, boolean]>([
    ["loading", { firstFrame: null }, false],
    ["loading", { firstFrame: null, stream: "retrying" }, false],
    ["none", {}, false],
    ["stalled", {}, true],
    ["retrying", { stream: "retrying" }, true],
    ["retrying", { stream: "connecting" }, false],
    ["retrying", { stream: "restarting" }, false],
    ["none", { stream: "retrying", complete: true }, false],
    ["none", { stream: "closed", complete: true }, false],
    ["lost", { contextLost: true, complete: true }, false],
  ])("is %s", (kind, fields, stalled) => {
    expect(noticeKind(stats(fields), stalled)).toBe(kind);
  });
});
