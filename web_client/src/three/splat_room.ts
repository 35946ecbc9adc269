/** The room of a scene's splats, for three.js' queries. */

import { Box3, Vector3 } from "three";
import type { Box, Manifest } from "../codec/types";

/** The bounds of the splats' centres at all times. */
export function roomOf(manifest: Manifest): Box3 {
  const room = new Box3();
  const chunks = [...manifest.static, ...manifest.slices.flatMap((slice) => slice.chunks)];
  for (const chunk of chunks) room.union(box3(chunk.box));
  return room;
}

const box3 = ({ min, max }: Box): Box3 => new Box3(new Vector3(...min), new Vector3(...max));
