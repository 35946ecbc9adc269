/** Figures of a running player, for people. */

/** "512 kbit/s", "1.9 Mbit/s" of bytes per second, as lines are sold. */
export function formatBitRate(bytesPerSecond: number): string {
  const kilobits = (8 * bytesPerSecond) / 1000;
  return kilobits < 999.5 ? `${Math.round(kilobits)} kbit/s` : `${(kilobits / 1000).toFixed(1)} Mbit/s`;
}

/** "950", "12.4k", "1.2M" */
export function formatCount(count: number): string {
  if (count < 1000) return String(count);
  if (count < 999_500) return `${(count / 1000).toFixed(count < 100_000 ? 1 : 0)}k`;
  return `${(count / 1e6).toFixed(1)}M`;
}
