import { describe, expect, it } from "vitest";
import type { PlayerStats } from "../../src/player/player_types";
import { describeNotice, type NoticeKind, noticeKind } from "../../src/ui/notices";
import { stats } from "../stats";

describe("noticeKind", () => {
  it.each<[NoticeKind, Partial<PlayerStats>, boolean]>([
    ["loading", { firstFrame: null }, false],
    ["loading", { firstFrame: null, stream: "retrying" }, false],
    ["none", {}, false],
    ["stalled", {}, true],
    ["retrying", { stream: "retrying" }, true],
    ["retrying", { stream: "connecting" }, false],
    ["none", { stream: "retrying", complete: true }, false],
    ["none", { stream: "closed", complete: true }, false],
    ["lost", { contextLost: true, complete: true }, false],
  ])("is %s", (kind, fields, stalled) => {
    expect(noticeKind(stats(fields), stalled)).toBe(kind);
  });
});

describe("describeNotice", () => {
  it("says how much of a scene is here", () => {
    expect(describeNotice("loading", stats())).toBe("Loading 100 KB of 400 KB");
    expect(describeNotice("stalled", stats())).toBe("Waiting for data: 100 KB of 400 KB");
  });

  it("says that there will be more of a scene that grows", () => {
    expect(describeNotice("stalled", stats({ atEdge: true }))).toBe("More of this scene is still being made…");
  });

  it("tells a connection that is lost from one that is being made", () => {
    expect(describeNotice("loading", stats({ bytesTotal: 0, stream: "connecting" }))).toBe("Connecting…");
    expect(describeNotice("loading", stats({ stream: "retrying" }))).toContain("Connection lost");
    expect(describeNotice("retrying", stats())).toContain("Connection lost");
  });
});
