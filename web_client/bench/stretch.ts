/** How long sound takes to be brought to another rate: `npm run bench:stretch`. */

import { stretched } from "../src/sound/stretch";

const SAMPLE_RATE = 48_000;
const LEAD = 5760; // samples
const ROUNDS = 10;

/** A second of a tone with noise, and what lies before. */
const noisy = () =>
  Float32Array.from({ length: SAMPLE_RATE + LEAD }, (_, i) => Math.sin(0.04 * i) + 0.2 * Math.random());

for (const rate of [0.25, 0.5, 2]) {
  const stereo = [noisy(), noisy()];
  stretched(stereo, LEAD, rate, SAMPLE_RATE);
  const begin = performance.now();
  for (let round = 0; round < ROUNDS; round++) stretched(stereo, LEAD, rate, SAMPLE_RATE);
  const each = (performance.now() - begin) / ROUNDS;
  process.stdout.write(`${each.toFixed(1)} ms for a second of stereo at rate ${rate}\n`);
}
