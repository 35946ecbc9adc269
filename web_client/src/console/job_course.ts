/** The course of a job, from stored reports and from those received while the page is open. */

import type { Job, JobPoint } from "../protocol/api";

const MOST_POINTS = 4000;
/** Share of a stage before its speed predicts the rest: the first steps are unlike the others. */
const LEAST_SHARE = 0.02;
const LEAST_SECONDS = 5;

export class JobCourse {
  #points: JobPoint[] = [];

  get points(): readonly JobPoint[] {
    return this.#points;
  }

  /** Start, or start again, with the stored reports; later ones received meanwhile follow. */
  start(kept: readonly JobPoint[]): void {
    const last = kept.at(-1)?.time ?? Number.NEGATIVE_INFINITY;
    const since = this.#points.filter((point) => point.time > last);
    this.#points = [...kept];
    for (const point of since) this.#add(point);
  }

  /** Add the progress in a job's news. */
  follow(job: Job): void {
    // A stage begins with 0 of 1, also when it continues from a checkpoint: that removes nothing.
    const { progress } = job;
    if (job.state !== "running" || !progress || (progress.done === 0 && progress.total <= 1)) return;
    this.#add({ ...progress, attempt: job.attempt, time: job.updated });
  }

  #add(point: JobPoint): void {
    while (this.#points.length > 0) {
      const last = this.#points[this.#points.length - 1];
      if (last.stage !== point.stage || last.done < point.done) break;
      this.#points.pop(); // it continued from a checkpoint, and reports again
    }
    this.#points.push(point);
    if (this.#points.length > MOST_POINTS) this.#points = this.#points.filter((_, i) => i % 2 === 1);
  }

  /** The figures of a stage, PSNR and loss first. */
  figures(stage: string): string[] {
    const names = new Set(["psnr", "loss"]);
    const reported = this.#points
      .filter((point) => point.stage === stage)
      .flatMap((point) => Object.keys(point.figures));
    for (const name of reported) names.add(name);
    return [...names].filter((name) => reported.includes(name));
  }

  /** A figure over a stage's progress: [done, value]. */
  curve(stage: string, figure: string): [number, number][] {
    return this.#points
      .filter((point) => point.stage === stage && point.figures[figure] !== undefined)
      .map((point) => [point.done, point.figures[figure]]);
  }

  /**
   * Remaining seconds of the present stage, about, at the speed of the latter half of this attempt's work on it; null
   * while there is too little data.
   */
  remaining(job: Job): number | null {
    const { progress } = job;
    if (job.state !== "running" || !progress || progress.total <= 1) return null;
    const own = this.#points.filter((point) => point.stage === progress.stage && point.attempt === job.attempt);
    const first = own[0];
    const last = own.at(-1);
    if (!first || !last || last.done - first.done < LEAST_SHARE * progress.total) return null;
    if (last.time - first.time < LEAST_SECONDS) return null;
    const middle = own.filter((point) => point.done <= (first.done + last.done) / 2).at(-1) ?? first;
    return ((progress.total - last.done) * (last.time - middle.time)) / (last.done - middle.done);
  }
}
