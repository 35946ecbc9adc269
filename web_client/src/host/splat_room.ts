/** The room of a scene's splats, for queries of hosts. */

import type { Box, Manifest } from "../codec/types";

/** The bounds of the splats' centres at all times. */
export function roomOf(manifest: Manifest): Box {
  const min: [number, number, number] = [Infinity, Infinity, Infinity];
  const max: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (const { box } of [...manifest.static, ...manifest.slices.flatMap((slice) => slice.chunks)]) {
    for (const i of [0, 1, 2]) {
      min[i] = Math.min(min[i], box.min[i]);
      max[i] = Math.max(max[i], box.max[i]);
    }
  }
  return { min, max };
}
