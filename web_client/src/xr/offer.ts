/** Which kinds of sessions this browser and its headset offer. */

export type HeadsetMode = "immersive-vr" | "immersive-ar";

const MODES: readonly HeadsetMode[] = ["immersive-vr", "immersive-ar"];

/** None without WebXR, which browsers offer on secure pages only, or without a headset. */
export async function offeredModes(xr: XRSystem | undefined): Promise<HeadsetMode[]> {
  if (!xr) return [];
  const offered = MODES.map((mode) => xr.isSessionSupported(mode).catch(() => false)); // a policy forbids to ask
  return Promise.all(offered).then((answers) => MODES.filter((_, i) => answers[i]));
}
