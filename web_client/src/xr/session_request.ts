/** The request of a session, and the sentences for a refusal. */

import type { HeadsetMode } from "./offer";

/**
 * Ask for a session; only while the browser handles a click or a key.
 *
 * @throws DOMException, for `describeRefusal`
 */
export function requestSession(xr: XRSystem, mode: HeadsetMode): Promise<XRSession> {
  return xr.requestSession(mode, { optionalFeatures: ["local-floor", "bounded-floor", "hand-tracking"] });
}

/** The sentence for a headset that could not be entered. */
export function describeRefusal(error: unknown): string {
  switch (error instanceof DOMException ? error.name : "") {
    case "NotAllowedError":
    case "SecurityError":
      return "The browser did not allow this page to use the headset. Allow it in the site settings, then try again.";
    case "NotSupportedError":
      return "This headset cannot show the scene.";
    case "InvalidStateError":
      return "The headset is in use. Close what it shows now, then try again.";
    default:
      return "The headset could not be started.";
  }
}
