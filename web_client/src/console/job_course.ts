/** The course of a job, from stored reports and from those received while the page is open. */

import type { Job, JobPoint } from "../protocol/api";

const MOST_POINTS = 4000;

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
}
