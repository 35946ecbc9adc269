/** What a scene says of itself, in words. */

import type { Scene } from "../protocol/api";
import { formatBytes } from "../ui/format";

/** "1.2 MB · 28% moving" */
export function describeScene({ bytes_total, splats_static, splats_dynamic }: Scene): string {
  const share = Math.round((100 * splats_dynamic) / (splats_static + splats_dynamic));
  return [formatBytes(bytes_total), splats_dynamic > 0 ? `${share}% moving` : "still"].join(" · ");
}

/** What is to be known before it is opened: that there will be more of it. Empty for a scene that is complete. */
export const sceneBadge = ({ live }: Scene): string => (live ? "Still being made" : "");
