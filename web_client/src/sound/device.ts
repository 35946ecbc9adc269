/** The browser's device for sound: its rate, its samples and its clock. */

/**
 * A context with the recording's rate, so that pieces need no resampling, which would leave artefacts at the ends of
 * each.
 */
export function newContext(sampleRate: number): AudioContext {
  try {
    return new AudioContext({ sampleRate });
  } catch {
    return new AudioContext(); // the browser does not support the rate
  }
}

/** The nearest time of a sample, seconds. */
export const toSample = (seconds: number, { sampleRate }: AudioContext): number =>
  Math.round(seconds * sampleRate) / sampleRate;

/** The current output: seconds of the sound's clock, at milliseconds of the page's. */
export function outputTime(context: AudioContext): { contextTime: number; performanceTime: number } {
  const { contextTime = 0, performanceTime = 0 } = context.getOutputTimestamp?.() ?? {};
  if (performanceTime > 0) return { contextTime, performanceTime };
  const latency = context.outputLatency || context.baseLatency || 0;
  return { contextTime: context.currentTime - latency, performanceTime: performance.now() };
}
