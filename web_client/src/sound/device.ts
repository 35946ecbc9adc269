/** The browser's device for sound: its rate, its samples, and what of it is heard when. */

/** At the rate of what was recorded, so that pieces need no resampling, of which each would have its own ends. */
export function newContext(sampleRate: number): AudioContext {
  try {
    return new AudioContext({ sampleRate });
  } catch {
    return new AudioContext(); // a rate that this browser does not know
  }
}

/** The nearest moment of a sample, seconds. */
export const toSample = (seconds: number, { sampleRate }: AudioContext): number =>
  Math.round(seconds * sampleRate) / sampleRate;

/** What is heard now: seconds of the sound's clock, at milliseconds of the page's. */
export function outputTime(context: AudioContext): { contextTime: number; performanceTime: number } {
  const { contextTime = 0, performanceTime = 0 } = context.getOutputTimestamp?.() ?? {};
  if (performanceTime > 0) return { contextTime, performanceTime };
  const latency = context.outputLatency || context.baseLatency || 0;
  return { contextTime: context.currentTime - latency, performanceTime: performance.now() };
}
