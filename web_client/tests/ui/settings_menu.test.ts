import { expect, it } from "vitest";
import { readableCameraNames } from "../../src/ui/settings_menu";

it.each([
  ["cam00", "Camera 0"],
  ["cam12", "Camera 12"],
  ["camera_07", "Camera 7"],
  ["frame_00012.jpg", "Frame 12"],
  ["left-side", "Left side"],
  ["000", "0"],
  ["Kamera Süd", "Kamera Süd"],
  ["_", "_"],
])("calls %s %s", (name, readable) => {
  expect(readableCameraNames([name])).toEqual([readable]);
});

it("keeps the names of cameras that would look the same", () => {
  expect(readableCameraNames(["cam1", "cam01", "cam2"])).toEqual(["cam1", "cam01", "Camera 2"]);
});
