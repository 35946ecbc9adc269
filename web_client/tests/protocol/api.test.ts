import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { submitJob } from "../../src/protocol/api";

const SUBMISSION = { capture: "studio", title: "", preset: "preview" };
const JOB = { id: "studio-1", state: "queued" };

/** Answer the requests in order; returns their addresses. */
function answering(...answers: Response[]): string[] {
  const asked: string[] = [];
  vi.stubGlobal("fetch", (address: string, init: RequestInit = {}) => {
    asked.push(`${init.method ?? "GET"} ${address}`);
    return Promise.resolve(answers[asked.length - 1]);
  });
  return asked;
}

const looking = (): Response =>
  Response.json({ id: "a1", state: "looking" }, { status: 202, headers: { Location: "submissions/a1" } });

beforeEach(() => {
  vi.useFakeTimers({ shouldAdvanceTime: true, advanceTimeDelta: 1000 });
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("does not ask again for a job that is made at once", async () => {
  const asked = answering(Response.json(JOB, { status: 201 }));
  expect((await submitJob(SUBMISSION)).id).toBe("studio-1");
  expect(asked).toEqual(["POST /v1/jobs"]);
});

it("asks where the server says while the capture is looked at", async () => {
  const asked = answering(looking(), looking(), Response.json(JOB));
  const waited = vi.fn();
  expect((await submitJob(SUBMISSION, waited)).id).toBe("studio-1");
  expect(waited).toHaveBeenCalledTimes(2);
  expect(asked).toEqual(["POST /v1/jobs", "GET /v1/submissions/a1", "GET /v1/submissions/a1"]);
});

it("passes on why a capture is refused after a look", async () => {
  const problem = { detail: "cam1.mp4: is damaged", code: "capture-invalid", field: "capture" };
  answering(looking(), Response.json(problem, { status: 422 }));
  await expect(submitJob(SUBMISSION)).rejects.toMatchObject({ status: 422, field: "capture" });
});
