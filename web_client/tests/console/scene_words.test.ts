import { expect, it } from "vitest";
import { describeScene, sceneBadge } from "../../src/console/scene_cards";
import type { Scene } from "../../src/protocol/api";

const scene = (fields: Partial<Scene>) =>
  ({
    bytes_total: 1_500_000,
    created: 1_795_867_200,
    splats_static: 3,
    splats_dynamic: 1,
    live: false,
    ...fields,
  }) as Scene;

it("tells a scene's date and size, and whether it is still", () => {
  expect(describeScene(scene({}))).toBe("28 Nov 2026 · 1.5 MB");
  expect(describeScene(scene({ splats_dynamic: 0 }))).toBe("28 Nov 2026 · 1.5 MB · still");
});

it("marks a scene that grows, and no other", () => {
  expect(sceneBadge(scene({ live: true }))).toBe("Still being made");
  expect(sceneBadge(scene({}))).toBe("");
});
