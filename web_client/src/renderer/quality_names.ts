/** What a viewer chooses. Auto: as fine as the device can at a steady rate while something moves, and finest at rest. */
export type Quality = "auto" | "high" | "medium" | "low";

export const QUALITIES: readonly Quality[] = ["auto", "high", "medium", "low"];
