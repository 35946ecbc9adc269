/** The kinds of sessions that this browser and its headset offer. */

export type HeadsetMode = "immersive-vr" | "immersive-ar";

const MODES: readonly HeadsetMode[] = ["immersive-vr", "immersive-ar"];

/** Chromium's policy of a page; in a frame it includes that of the page around it. */
interface Policed {
  readonly featurePolicy?: { allowsFeature(feature: string): boolean };
}

/**
 * The available kinds of sessions: none without WebXR, which browsers offer on secure pages only, or without a headset.
 */
export async function offeredModes(
  xr: XRSystem | undefined,
  { featurePolicy }: Policed = (globalThis.document as Policed | undefined) ?? {},
): Promise<HeadsetMode[]> {
  // A query against the policy would write an error into the console of the page around the frame.
  if (!xr || featurePolicy?.allowsFeature("xr-spatial-tracking") === false) return [];
  const offered = MODES.map((mode) => xr.isSessionSupported(mode).catch(() => false)); // a policy may forbid the query
  return Promise.all(offered).then((answers) => MODES.filter((_, i) => answers[i]));
}
