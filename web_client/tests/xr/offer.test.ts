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

  it("is nothing where a policy forbids to ask", async () => {
    const forbidden = () => Promise.reject(new DOMException("", "SecurityError"));
    expect(await offeredModes(system(forbidden))).toEqual([]);
  });
});
