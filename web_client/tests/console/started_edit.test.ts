import { describe, expect, it } from "vitest";
import { courseOf } from "../../src/console/started_edit";
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
