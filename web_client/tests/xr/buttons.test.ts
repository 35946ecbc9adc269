import { describe, expect, it } from "vitest";
import { Buttons } from "../../src/xr/buttons";

const gamepad = (lower: boolean, upper: boolean, stick: number) => ({
  buttons: [false, false, false, false, lower, upper].map((pressed) => ({ pressed }) as GamepadButton),
  axes: [0, 0, stick, 0],
});

describe("a controller", () => {
  it("tells of every press once", () => {
    const buttons = new Buttons();
    buttons.read(gamepad(false, false, 0));
    const pressed = [true, true, false, true].map((down) => buttons.read(gamepad(down, down, 0)));
    expect(pressed.map(({ lower }) => lower)).toEqual([true, false, false, true]);
    expect(pressed.map(({ upper }) => upper)).toEqual([true, false, false, true]);
  });

  it("takes for no press what is held from the beginning", () => {
    const { lower, upper, flick } = new Buttons().read(gamepad(true, true, 1));
    expect([lower, upper, flick]).toEqual([false, false, 0]);
  });

  it("tells of a push of its stick once, until the stick has come back", () => {
    const buttons = new Buttons();
    const flicks = [0, 0.8, 0.9, 0.5, 0.9, 0.1, -0.8].map((x) => buttons.read(gamepad(false, false, x)).flick);
    expect(flicks).toEqual([0, 1, 0, 0, 0, 0, -1]);
  });

  it("takes a stick that rests a little off for one that rests", () => {
    const buttons = new Buttons();
    expect(buttons.read(gamepad(false, false, 0.1)).stick).toBe(0);
    expect(buttons.read(gamepad(false, false, -0.5)).stick).toBe(-0.5);
  });

  it("without sticks and buttons tells of nothing", () => {
    const none = new Buttons().read({ buttons: [], axes: [] });
    expect(none).toEqual({ lower: false, upper: false, flick: 0, stick: 0 });
  });
});
