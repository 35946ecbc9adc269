/** Which kinds of sessions this browser and its headset offer. */

export type HeadsetMode = "immersive-vr" | "immersive-ar";

const MODES: readonly HeadsetMode[] = ["immersive-vr", "immersive-ar"];

/** What Chromium tells of the policy of a page; in a frame it is the page's around it. */
interface Policed {
  readonly featurePolicy?: { allowsFeature(feature: string): boolean };
}

/** None without WebXR, which browsers offer on secure pages only, or without a headset. */
export async function offeredModes(
  xr: XRSystem | undefined,
  { featurePolicy }: Policed = (globalThis.document as Policed | undefined) ?? {},
): Promise<HeadsetMode[]> {
  // Whoever asks all the same has an error written into the console of the page around the frame.
  if (!xr || featurePolicy?.allowsFeature("xr-spatial-tracking") === false) return [];
  const offered = MODES.map((mode) => xr.isSessionSupported(mode).catch(() => false)); // a policy forbids to ask
  return Promise.all(offered).then((answers) => MODES.filter((_, i) => answers[i]));
}
