import { describe, expect, it } from "vitest";
import type { Vec3 } from "../../src/camera/vector";
import { Grab, type Hold, turned } from "../../src/xr/grab";
import { inverse, type Similarity, transformed, yawRotation } from "../../src/xr/similarity";

const [left, right] = [{}, {}];
const hold = (hand: object, position: Vec3, yaw = 0): Hold => ({ hand, position, rotation: yawRotation(yaw) });
const start: Similarity = { rotation: yawRotation(0.2), scale: 2, translation: [1, 2, 3] };
const close = (a: Vec3, b: Vec3) => {
  for (const i of [0, 1, 2]) expect(a[i]).toBeCloseTo(b[i], 10);
};
/** Where in the room a point of the scene is. */
const inRoom = (sceneFromRoom: Similarity, point: Vec3) => transformed(inverse(sceneFromRoom), point);

describe("a grab", () => {
  it("takes along what one hand holds, and turns it as the hand turns", () => {
    const grab = new Grab();
    const held = transformed(start, [0.1, 1, -0.5]);
    const beyond = transformed(start, [0.1, 1, -1.5]); // a metre behind it
    grab.update(start, [hold(right, [0.1, 1, -0.5])], 2);
    const place = grab.update(start, [hold(right, [0.4, 1.2, -0.6], Math.PI / 2)], 2);
    close(inRoom(place, held), [0.4, 1.2, -0.6]);
    close(inRoom(place, beyond), [-0.6, 1.2, -0.6]);
  });

  it("keeps the vertical upright however the hand tilts", () => {
    const grab = new Grab();
    const tilted: Hold = { hand: right, position: [0, 1, 0], rotation: [1, 0, 0, 0, 0.6, -0.8, 0, 0.8, 0.6] };
    grab.update(start, [hold(right, [0, 1, 0])], 2);
    const place = grab.update(start, [tilted], 2);
    expect(place.rotation[4]).toBeCloseTo(1, 12);
    close(transformed(place, [0, 1, 0]), transformed(start, [0, 1, 0]));
  });

  it("scales between two hands, each of which keeps what it holds", () => {
    const grab = new Grab();
    const [a, b] = [transformed(start, [-0.2, 1, -0.5]), transformed(start, [0.2, 1, -0.5])];
    grab.update(start, [hold(left, [-0.2, 1, -0.5]), hold(right, [0.2, 1, -0.5])], 2);
    const place = grab.update(start, [hold(left, [0, 1.1, -0.1]), hold(right, [0, 1.1, -0.9])], 2);
    close(inRoom(place, a), [0, 1.1, -0.1]);
    close(inRoom(place, b), [0, 1.1, -0.9]);
    expect(place.scale).toBeCloseTo(1, 12); // twice as large
  });

  it("goes no further than fifty times the first size", () => {
    const grab = new Grab();
    let place = start;
    for (let i = 0; i < 20; i++) {
      grab.update(place, [], 2);
      grab.update(place, [hold(left, [-0.1, 1, 0]), hold(right, [0.1, 1, 0])], 2);
      place = grab.update(place, [hold(left, [-0.5, 1, 0]), hold(right, [0.5, 1, 0])], 2);
    }
    expect(place.scale).toBeCloseTo(2 / 50, 10);
  });

  it("does not jump when a second hand joins or one lets go", () => {
    const grab = new Grab();
    grab.update(start, [hold(right, [0, 1, 0])], 2);
    expect(grab.update(start, [hold(right, [0, 1, 0]), hold(left, [-1, 1, 0])], 2)).toBe(start);
    expect(grab.update(start, [hold(left, [-1, 1, 0])], 2)).toBe(start);
    expect(grab.update(start, [], 2)).toBe(start);
    expect(grab.update(start, [hold(right, [5, 1, 0])], 2)).toBe(start);
  });
});

describe("a turn", () => {
  it("to the left brings what was on the left ahead, and the head stays where it is", () => {
    const head: Vec3 = [0.5, 1.6, 0.25];
    const onTheLeft = transformed(start, [-0.5, 1.6, 0.25]);
    const place = turned(start, head, Math.PI / 2);
    close(inRoom(place, onTheLeft), [0.5, 1.6, -0.75]);
    close(transformed(place, head), transformed(start, head));
  });
});
