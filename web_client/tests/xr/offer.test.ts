import { describe, expect, it } from "vitest";
import { offeredModes } from "../../src/xr/offer";

const system = (answer: (mode: string) => Promise<boolean>) => ({ isSessionSupported: answer }) as unknown as XRSystem;

describe("what a browser offers", () => {
  it("is nothing without WebXR", async () => {
    expect(await offeredModes(undefined)).toEqual([]);
  });

  it("is what its headset can do", async () => {
    expect(await offeredModes(system(async (mode) => mode === "immersive-ar"))).toEqual(["immersive-ar"]);
  });

  it.each([true, false])("is not asked for where the page's policy forbids it: allowed %s", async (allowed) => {
    let asked = 0;
    const headset = system(async () => ++asked > 0);
    const featurePolicy = { allowsFeature: (feature: string) => feature !== "xr-spatial-tracking" || allowed };
    expect((await offeredModes(headset, { featurePolicy })).length).toBe(allowed ? 2 : 0);
    expect(asked).toBe(allowed ? 2 : 0);
  });

  it("is nothing where a policy forbids to ask", async () => {
    const forbidden = () => Promise.reject(new DOMException("", "SecurityError"));
    expect(await offeredModes(system(forbidden))).toEqual([]);
  });
});
