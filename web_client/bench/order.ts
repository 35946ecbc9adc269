/**
 * How much processor time an order takes while the camera turns: `npm run bench:order`. Ours and a radix sort by all bits
 * of all splats, as it was before, take turns; medians over the rounds.
 */

import { frustumOf } from "../src/worker/frustum";
import { SplatOrderer } from "../src/worker/splat_order";
import { cloud, turning } from "./clouds";
import { PlainOrderer } from "./plain_order";

const ROUNDS = 25;
const ARC = (1.5 * Math.PI) / 180; // 90 degrees a second at 60 orders a second

/** Milliseconds of the processor. */
function cost(work: () => void): number {
  const begun = process.cpuUsage();
  work();
  const { user, system } = process.cpuUsage(begun);
  return (user + system) / 1000;
}

const median = (values: number[]): number => values.sort((a, b) => a - b)[values.length >> 1];

for (const count of [100_000, 300_000, 1_000_000, 3_000_000]) {
  for (const [what, distance] of [
    ["all in the picture", 8],
    ["from within", 0],
  ] as const) {
    const chunk = cloud(count);
    const ours = new SplatOrderer(chunk.manifest, chunk.placement);
    ours.add("cloud", chunk.splats);
    const plain = new PlainOrderer(chunk.splats.means);
    const costs: [number[], number[], number[]] = [[], [], []];
    let recycled: Uint32Array<ArrayBuffer> | undefined;
    let shown = 0;
    for (let round = 0; round < ROUNDS; round++) {
      const { pose, camera, depth } = turning(round * ARC, distance);
      costs[0].push(cost(() => plain.order(depth)));
      for (const [i, exact] of [false, true].entries()) {
        costs[1 + i].push(
          cost(() => {
            const frustum = frustumOf(pose, camera);
            const request = { depth, frustum, exact, budget: Infinity, time: 0, from: 0, until: 0 };
            const order = ours.order(request, recycled);
            recycled = order.ids;
            shown = order.count;
          }),
        );
      }
    }
    const [before, moving, exact] = costs.map((values) => median(values.slice(3)).toFixed(1));
    const line = `${count} splats, ${what}: before ${before}, moving ${moving}, exact ${exact} ms; ${shown} in the order`;
    process.stdout.write(`${line}\n`);
  }
}
