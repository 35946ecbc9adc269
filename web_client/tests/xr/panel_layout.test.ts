import { describe, expect, it } from "vitest";
import { CONTROLS, controlAt, onPanel, pointOn, rayOf, shareAt } from "../../src/xr/panel_layout";
import { yawRotation } from "../../src/xr/similarity";

const panel = { position: [0, 1, -2], rotation: yawRotation(0) } as const;
const ahead = (x: number, y: number) => ({ origin: [x, y, 0], direction: [0, 0, -1] }) as const;

describe("the panel", () => {
  it("is met by a ray where the picture has that point, its top left first", () => {
    expect(pointOn(panel, ahead(0, 1))).toMatchObject({ x: 512, y: 160, distance: 2 });
    const corner = pointOn(panel, ahead(-0.32, 1.1));
    expect(corner?.x).toBeCloseTo(0, 8);
    expect(corner?.y).toBeCloseTo(0, 8);
  });

  it("is not met from behind, along it, or backwards", () => {
    expect(pointOn(panel, { origin: [0, 1, -3], direction: [0, 0, 1] })).toBeNull();
    expect(pointOn(panel, { origin: [0, 1, 0], direction: [1, 0, 0] })).toBeNull();
    expect(pointOn(panel, { origin: [0, 1, -3], direction: [0, 0, -1] })).toBeNull();
  });

  it("is missed beside its edges", () => {
    const beside = pointOn(panel, ahead(0.33, 1));
    expect(beside && onPanel(beside)).toBe(false);
  });

  it("has a control at the middle of each, and none between them", () => {
    for (const [name, { x, y, width, height }] of Object.entries(CONTROLS)) {
      expect(controlAt(x + width / 2, y + height / 2)).toBe(name);
    }
    expect(controlAt(500, 300)).toBeNull();
  });

  it("has a bar whose ends are the scene's", () => {
    expect([0, 208, 596, 984, 2000].map(shareAt)).toEqual([0, 0, 0.5, 1, 1]);
  });
});

describe("a ray", () => {
  it("goes ahead of what points", () => {
    const { direction } = rayOf({ position: [0, 0, 0], rotation: yawRotation(Math.PI / 2) });
    expect(direction[0]).toBeCloseTo(-1, 12);
    expect(direction[2]).toBeCloseTo(0, 12);
  });
});
