import { describe, expect, it } from "vitest";
import { JobCourse } from "../../src/console/job_course";
import type { Job, JobPoint } from "../../src/protocol/api";

const point = (done: number, fields: Partial<JobPoint> = {}): JobPoint => ({
  attempt: 1,
  stage: "train",
  done,
  total: 1000,
  time: done / 10,
  figures: { psnr: 20 + done / 100 },
  ...fields,
});

const news = (done: number, fields: Partial<Job> = {}): Job => ({
  id: "a",
  state: "running",
  attempt: 1,
  capture: "/captures/studio",
  title: "Studio",
  preset: "preview",
  config: {},
  audio: null,
  stage: "train",
  progress: { stage: "train", done, total: 1000, figures: { psnr: 20 + done / 100, loss: 0.1 } },
  error: null,
  waiting: null,
  scene: null,
  created: 0,
  ends: null,
  updated: done / 10,
  ...fields,
});

const course = (...points: JobPoint[]): JobCourse => {
  const made = new JobCourse();
  made.start(points);
  return made;
};

describe("JobCourse", () => {
  it("goes on from what the server kept, also with what came in before it was asked", () => {
    const made = new JobCourse();
    made.follow(news(300));
    made.start([point(100), point(200)]);
    made.follow(news(400));
    expect(made.curve("train", "psnr")).toEqual([
      [100, 21],
      [200, 22],
      [300, 23],
      [400, 24],
    ]);
  });

  it("begins again with what the server kept, when that tells more than the news did", () => {
    const prepared = point(1, { stage: "prepare", total: 1, time: 0 });
    const made = course(prepared, point(100));
    made.follow(news(900));
    made.start([prepared, point(100), point(900), point(1000), point(1, { stage: "encode", total: 1, time: 101 })]);
    expect(made.points.map(({ stage, done }) => [stage, done])).toEqual([
      ["prepare", 1],
      ["train", 100],
      ["train", 900],
      ["train", 1000],
      ["encode", 1],
    ]);
  });

  it("takes back what a stage reports again after a checkpoint", () => {
    const made = course(point(100), point(200), point(300));
    made.follow(news(200, { attempt: 2 }));
    expect(made.points.map(({ done }) => done)).toEqual([100, 200]);
  });

  it("keeps its curve when a stage says that it begins, and while a job waits", () => {
    const made = course(point(100));
    made.follow(news(0, { progress: { stage: "train", done: 0, total: 1, figures: {} } }));
    made.follow(news(50, { state: "queued" }));
    expect(made.points.map(({ done }) => done)).toEqual([100]);
  });

  it("begins with the first report of all", () => {
    const made = new JobCourse();
    for (const done of [0, 80]) made.follow(news(done));
    expect(made.curve("train", "psnr")).toHaveLength(2);
  });

  it("lists the figures of a stage, PSNR and loss first", () => {
    const made = course(
      point(1, { stage: "masks", figures: { share: 1 } }),
      point(100, { figures: { static: 5, loss: 1, psnr: 20 } }),
    );
    expect(made.figures("train")).toEqual(["psnr", "loss", "static"]);
    expect(made.figures("encode")).toEqual([]);
  });

  it("stays small", () => {
    const made = new JobCourse();
    for (let done = 1; done <= 20_000; done++)
      made.follow(news(done, { progress: { stage: "train", done, total: 20_000, figures: {} } }));
    expect(made.points.length).toBeLessThanOrEqual(4000);
    expect(made.points.at(-1)?.done).toBe(20_000);
  });
});
