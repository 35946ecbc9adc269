import { describe, expect, it } from "vitest";
import { DYNAMIC_TEXELS, FIFTH_TEXELS, FIFTH_WIDTH, TEXTURE_WIDTH } from "../../src/renderer/layout";
import { packDynamics, packFifth } from "../../src/worker/pack";
import { dynamicChunk } from "../scene";

describe("packFifth", () => {
  it("packs nothing for motions that are cubics", () => {
    const chunk = dynamicChunk([1], [2], [0], 0);
    expect(packFifth(chunk)).toHaveLength(0);
    expect(packDynamics(chunk)[4 * 7 + 1]).toBe(0);
  });

  it("puts the coefficients above the cubic into rows beside those of the dynamics", () => {
    const depths = Array.from({ length: 300 }, () => 1);
    const fifth = depths.map((_, i) => (i === 299 ? 0.5 : 0));
    const chunk = dynamicChunk(depths, depths, depths, 0, fifth);
    const texels = packDynamics(chunk);
    const higher = packFifth(chunk);
    expect(texels.length / (4 * TEXTURE_WIDTH)).toBe(2);
    expect(higher.length / (4 * FIFTH_WIDTH)).toBe(2);
    expect(texels[4 * DYNAMIC_TEXELS * 299 + 2]).toBe(1); // z of m0
    expect([298, 299].map((i) => texels[4 * (DYNAMIC_TEXELS * i + 7) + 1])).toEqual([0, 1]);
    expect(higher.findIndex((m) => m !== 0)).toBe(4 * (FIFTH_TEXELS * 299 + 1) + 2); // z of m5
  });
});
