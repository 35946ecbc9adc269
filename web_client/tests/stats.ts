/** What a player tells of itself, for tests. */

import type { PlayerStats } from "../src/player/player_types";
import { LADDER } from "../src/renderer/fineness";

/** A player that shows a scene of which a quarter is here. */
export const stats = (fields: Partial<PlayerStats> = {}): PlayerStats => ({
  stream: "open",
  bytes: 100_000,
  bytesTotal: 400_000,
  lineRate: 250_000,
  chunks: 3,
  lostChunks: 0,
  complete: false,
  atEdge: false,
  splats: 1000,
  dynamicSplats: 100,
  framesPerSecond: 60,
  framesDrawn: 90,
  framesDropped: 10,
  sortTime: 1.25,
  orderAge: 16.4,
  orderAgeFrames: 1,
  pictureTime: 0.5,
  fineness: LADDER[0],
  contextLost: false,
  setAside: false,
  firstFrame: 800,
  loadStart: 0,
  ...fields,
});
