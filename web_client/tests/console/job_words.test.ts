import { describe, expect, it } from "vitest";
import {
  captureName,
  describeFault,
  describeFigures,
  describeProgress,
  describeQueue,
  describeRemaining,
  describeSound,
  stepOf,
  titleOf,
} from "../../src/console/job_words";
import type { Job } from "../../src/protocol/api";

const job = (fields: Partial<Job>): Job => ({
  id: "a",
  state: "running",
  attempt: 1,
  config: {},
  audio: null,
  capture: "/captures/studio",
  title: "Studio",
  preset: "preview",
  stage: null,
  progress: null,
  error: null,
  waiting: null,
  scene: null,
  created: 0,
  ends: null,
  updated: 0,
  ...fields,
});

describe("describeProgress", () => {
  it.each<[string, Partial<Job>]>([
    ["Queued", { state: "queued" }],
    ["Waiting", { state: "waiting", waiting: "the disk is full" }],
    ["Starting", {}],
    ["Encoding", { stage: "encode" }],
    ["Checking the capture", { progress: { stage: "initialise", done: 0, total: 1, figures: {} } }],
    ["Finding what moves 3 / 16", { progress: { stage: "masks", done: 3, total: 16, figures: {} } }],
    ["Placing points 4 / 9", { progress: { stage: "points", done: 4, total: 9, figures: {} } }],
    ["Depth maps 3 / 16", { progress: { stage: "depth_maps", done: 3, total: 16, figures: {} } }],
    ["Training 1,840 / 4,000", { progress: { stage: "train", done: 1840, total: 4000, figures: {} } }],
    ["Cancelled", { state: "cancelled", stage: "train" }],
  ])("says %s", (text, fields) => {
    expect(describeProgress(job(fields))).toBe(text);
  });
});

describe("describeSound", () => {
  it.each<[string, string | null]>([
    ["", null],
    ["", "auto"],
    ["no sound", "none"],
    ["sound of cam01", "camera:cam01"],
    ["sound of recorder.wav", "/captures/studio/recorder.wav"],
  ])("says “%s” of %s", (text, audio) => {
    expect(describeSound(job({ audio }))).toBe(text);
  });
});

describe("stepOf", () => {
  it("goes through the steps in the order of the stages", () => {
    const stages = ["initialise", "check", "frames", "masks", "points", "train", "encode", "publish"];
    expect(stages.map((stage) => stepOf(job({ stage })))).toEqual([0, 0, 1, 1, 2, 3, 4, 5]);
  });

  it("knows no step of a stage that is not there yet or not known", () => {
    expect(stepOf(job({}))).toBe(-1);
    expect(stepOf(job({ stage: "depth_maps" }))).toBe(-1);
  });
});

describe("describeFault", () => {
  it.each<[string, Partial<Job>]>([
    ["", {}],
    ["the loss is not a number", { state: "failed", error: "the loss is not a number" }],
    ["Waiting: the disk is full", { state: "waiting", waiting: "the disk is full" }],
    ["", { state: "cancelled", waiting: "the disk is full" }],
  ])("says %j", (text, fields) => {
    expect(describeFault(job(fields))).toBe(text);
  });
});

describe("describeFigures", () => {
  it("rounds to three digits but leaves counts whole", () => {
    const figures = { loss: 0.04123, splats_static: 48210 };
    const progress = { stage: "train", done: 1, total: 2, figures };
    expect(describeFigures(job({ progress }))).toBe("Loss 0.0412 · Splats static 48,210");
  });

  it("says nothing of a job that has ended", () => {
    const progress = { stage: "train", done: 1, total: 2, figures: { loss: 1 } };
    expect(describeFigures(job({ state: "failed", progress }))).toBe("");
  });
});

describe("titleOf", () => {
  it("falls back to the folder of the capture, then to the id", () => {
    expect(titleOf(job({ title: "Mine" }))).toBe("Mine");
    expect(titleOf(job({ title: null }))).toBe("studio");
    expect(titleOf(job({ title: null, capture: "" }))).toBe("a");
    expect(captureName(job({ capture: "/captures/shows/two/" }))).toBe("two");
  });
});

describe("describeQueue", () => {
  it.each<[string, number | null]>([
    ["", null],
    ["Next in line: it starts as soon as a worker is free.", 0],
    ["One other job is ahead of it.", 1],
    ["About 1,200 other jobs are ahead of it.", 1200],
  ])("says %j", (text, ahead) => {
    expect(describeQueue(ahead)).toBe(text);
  });
});

describe("describeRemaining", () => {
  it.each<[string, number | null]>([
    ["", null],
    ["less than a minute left", 1012],
    ["about 1 min left", 1061],
    ["about 89 min left", 1000 + 89 * 60],
    ["about 3 h left", 1000 + 3.2 * 3600],
  ])("says %j", (text, ends) => {
    expect(describeRemaining(job({ updated: 1000, ends }))).toBe(text);
  });
});
