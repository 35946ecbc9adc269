/** The room of a scene's splats as three.js' queries need it. */

import { Box3, Vector3 } from "three";
import type { Manifest } from "../codec/types";
import { roomOf } from "../host/splat_room";

/** The bounds of the splats' centres at all times. */
export function splatBox(manifest: Manifest): Box3 {
  const { min, max } = roomOf(manifest);
  return new Box3(new Vector3(...min), new Vector3(...max));
}
