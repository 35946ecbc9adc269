/** How long to wait before another attempt, after a failure. */

/** Longest wait before the first retry, ms; doubled at each failure. */
const FIRST_RETRY = 500;
const LAST_RETRY = 8000; // ms

/** Milliseconds, anywhere in a span, so that all viewers of a server that has come back do not come at once. */
export const retryDelay = (failures: number): number =>
  Math.min(LAST_RETRY, FIRST_RETRY * 2 ** failures) * Math.random();
