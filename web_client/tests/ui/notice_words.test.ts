import { describe, expect, it } from "vitest";
import { describeNotice } from "../../src/ui/notice_words";
import { stats } from "../stats";

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

  it("says that a server that stops is awaited", () => {
    const sentence = "The server is restarting. One moment…";
    expect(describeNotice("loading", stats({ stream: "restarting" }))).toBe(sentence);
    expect(describeNotice("retrying", stats({ stream: "restarting" }))).toBe(sentence);
  });
});
