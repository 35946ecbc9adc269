/** The space in which a headset tells where it is. */

import { EYE_HEIGHT } from "./standing_place";

export interface HeadsetSpace {
  readonly space: XRReferenceSpace;
  /** How far above the space's origin the eyes of somebody who stands there are, metres. */
  readonly eyeHeight: number;
}

/** With the floor at height 0 where the headset knows it, else about the head as it is now, as for somebody who sits. */
const KINDS: readonly (readonly [XRReferenceSpaceType, number])[] = [
  ["local-floor", EYE_HEIGHT],
  ["bounded-floor", EYE_HEIGHT],
  ["local", 0],
];

/** @throws DOMException if the session offers none. */
export async function requestSpace(session: XRSession): Promise<HeadsetSpace> {
  let refusal: unknown;
  for (const [kind, eyeHeight] of KINDS) {
    try {
      return { space: await session.requestReferenceSpace(kind), eyeHeight };
    } catch (error) {
      refusal = error;
    }
  }
  throw refusal;
}
