/**
 * Time stretching of sound at constant pitch (WSOLA: Verhelst & Roelands, ICASSP 1993): short frames overlap at another
 * distance, each shifted by a few milliseconds to continue its predecessor best.
 */

/** Half of a frame, seconds; two of a voice's lowest periods. */
const HALF = 0.016;
/** Largest shift of a frame, seconds. */
const REACH = 0.008;
/** Samples between two candidates, and between two compared samples, in the first round. */
const COARSE = 6;

/**
 * The samples of every channel from `begin` on, which must be in all of them, in 1 / `rate` of the time.
 *
 * Frames at both ends have no shift, so that adjacent parts, stretched separately, join.
 */
export function stretched(
  channels: readonly Float32Array[],
  begin: number,
  rate: number,
  sampleRate: number,
): Float32Array<ArrayBuffer>[] {
  const end = channels[0].length;
  const length = Math.round((end - begin) / rate);
  const frames = Math.max(1, Math.round(length / (HALF * sampleRate)));
  const hop = length / frames;
  const half = Math.ceil(hop);
  const mixed = channels.length === 1 ? channels[0] : channels[0].map((sample, i) => sample + channels[1][i]);
  const made = channels.map(() => new Float32Array(length));
  let middle = begin; // source of the previous frame
  for (let frame = 0; frame <= frames; frame++) {
    const there = Math.round(frame * hop);
    const place = Math.min(end, Math.round(begin + frame * hop * rate));
    const fixed = frame === 0 || frame === frames;
    const reach = Math.min(Math.round(REACH * sampleRate), place - half, end - half - place);
    const expected = Math.max(half, Math.min(middle + Math.round(hop), end - half));
    middle = fixed || reach <= 0 ? place : place + likest(mixed, expected - half, place - half, 2 * half, reach);
    for (const [i, channel] of channels.entries()) lay(made[i], channel, there, middle, hop);
  }
  return made;
}

/**
 * Add a frame with a weight that rises to 1 in its middle and falls again; the weights of two neighbours add up to 1.
 */
function lay(into: Float32Array, from: Float32Array, there: number, middle: number, hop: number): void {
  const [first, last] = [Math.max(-Math.floor(hop), -there), Math.min(Math.floor(hop), into.length - 1 - there)];
  for (let i = first; i <= last; i++) {
    into[there + i] += (from[middle + i] ?? 0) * (0.5 + 0.5 * Math.cos((Math.PI * i) / hop));
  }
}

/** The shift in samples, within `reach`, that makes the sound at `place` most similar to that at `like`. */
function likest(samples: Float32Array, like: number, place: number, count: number, reach: number): number {
  const rough = likestOf(samples, like, place, count, -reach, reach, COARSE);
  return likestOf(samples, like, place, count, Math.max(-reach, rough - COARSE), Math.min(reach, rough + COARSE), 1);
}

/** The same for shifts from `first` to `last` in steps, with as many times fewer samples. */
function likestOf(
  samples: Float32Array,
  like: number,
  place: number,
  count: number,
  first: number,
  last: number,
  stride: number,
): number {
  let [best, highest] = [first, Number.NEGATIVE_INFINITY];
  const skip = Math.max(2, stride);
  for (let move = first; move <= last; move += stride) {
    let [product, energy] = [0, 1e-9];
    for (let i = 0, at = place + move; i < count; i += skip) {
      const sample = samples[at + i];
      product += sample * samples[like + i];
      energy += sample * sample;
    }
    const likeness = product / Math.sqrt(energy);
    if (likeness > highest) [best, highest] = [move, likeness];
  }
  return best;
}
