import { afterEach, describe, expect, it, vi } from "vitest";
import { courseOf, editStarter } from "../../src/console/started_edit";
import type { Job } from "../../src/protocol/api";

const JOB = { id: "studio-1", state: "queued", scene: null, error: null, waiting: null, stage: null, progress: null };
const job = (changes: Partial<Job>) => ({ ...JOB, ...changes }) as Job;

describe("the course of an edit", () => {
  it("is that of its job", () => {
    const link = { name: "Job", address: "/job/studio-1" };
    expect(courseOf(job({}))).toEqual({ text: "Queued.", link, busy: true });
    const progress = { stage: "encode", done: 2, total: 4, figures: {} };
    expect(courseOf(job({ state: "running", progress })).text).toBe("Encoding 2 / 4.");
  });

  it("ends at the new scene", () => {
    const { link, busy } = courseOf(job({ state: "succeeded", scene: "studio-1" }));
    expect([link?.address, busy]).toEqual(["/view/studio-1", false]);
  });

  it("says why it failed", () => {
    const error = "splats.json: chunks.ab: is not a chunk of this scene";
    expect(courseOf(job({ state: "failed", error }))).toMatchObject({ text: error, busy: false });
  });
});

describe("requests for edits", () => {
  afterEach(() => vi.unstubAllGlobals());

  /** The keys of requests for these documents, one after the other; each is answered with the state, or not at all. */
  async function keysOf(...asked: readonly (readonly [string, Job["state"] | null])[]): Promise<(string | null)[]> {
    const keys: (string | null)[] = [];
    const start = editStarter("studio", new AbortController().signal);
    for (const [document, state] of asked) {
      vi.stubGlobal("fetch", async (_: string, { headers }: RequestInit) => {
        keys.push(new Headers(headers).get("Idempotency-Key"));
        if (state === null) throw new TypeError("no line");
        return Response.json(job({ state }), { status: 201 });
      });
      await new Promise<void>((resolve) => start(document, ({ text }) => text !== "Sending …" && resolve()));
    }
    return keys;
  }

  it("have one key while nothing changes, whether they are answered or not", async () => {
    const [first, second, third] = await keysOf(["a", null], ["a", "succeeded"], ["a", "succeeded"]);
    expect(first).toMatch(/^[0-9a-f]{32}$/);
    expect([second, third]).toEqual([first, first]);
  });

  it("have another key for another document, and after a job that failed or was cancelled", async () => {
    const keys = await keysOf(["a", "succeeded"], ["b", "failed"], ["b", "cancelled"], ["b", "succeeded"]);
    expect(new Set(keys).size).toBe(4);
  });
});
