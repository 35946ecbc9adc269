import { describe, expect, it } from "vitest";
import { poseAt } from "../../src/camera/pinhole";
import { areEyes, ViewOrders, type Views } from "../../src/host/view_orders";
import type { OrderKey } from "../../src/scene/order_requests";
import { sightOf, type View } from "../../src/scene/view";

const CAMERA = { width: 64, height: 48, fx: 50, fy: 50, cx: 32, cy: 24, near: 0.1 };

/** From a place a little nearer the further it is to the side, so that no two views have one depth. */
const at = (x: number): View => ({ pose: poseAt([x, 0, -3 + x / 10], [1, 0, 0, 0, 1, 0, 0, 0, 1]), camera: CAMERA });
const key = (view: View, exact = true): OrderKey => ({
  ...sightOf([view]),
  ...{ exact, budget: Infinity, time: 1, from: 1, until: 1, version: 4 },
});

/** Take the order of whose turn it is, so often; returns whose turn it was. */
function turns(orders: ViewOrders, views: Views, times: number, exact = true): number[] {
  return Array.from({ length: times }, () => {
    const place = orders.turn(views, 1, 4);
    orders.take(key(views[place], exact), new Uint32Array(2048).fill(place), 10);
    return place;
  });
}

describe("orders of several views", () => {
  it("are made in turn, each for its view, until all have theirs", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5), at(9)]];
    expect(turns(orders, views, 3).sort()).toEqual([0, 1, 2]);
    expect([0, 1, 2].map((place) => orders.at(place)?.ids[0])).toEqual([0, 1, 2]);
    expect(orders.all(views, 1, 4, true)).toBe(true);
    expect(orders.keys).toEqual(views.map((view) => key(view)));
  });

  it("are asked for anew where a view has moved, and only there", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5), at(9)]];
    turns(orders, views, 3);
    const moved: Views = [at(0), at(5), at(8)];
    expect(orders.all(moved, 1, 4, true)).toBe(false);
    expect(turns(orders, moved, 1)).toEqual([2]);
    expect(orders.all(moved, 1, 4, true)).toBe(true);
  });

  it("are out of date at another time and after more splats", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5)]];
    turns(orders, views, 2);
    expect(orders.all(views, 1.5, 4, true)).toBe(false);
    expect(orders.all(views, 1, 5, true)).toBe(false);
    expect(orders.all(views, 1.5, 5, false)).toBe(true);
  });

  it("follow a quick one by the exact one of the same view", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5)]];
    const [quick] = turns(orders, views, 1, false);
    expect(turns(orders, views, 1)).toEqual([quick]);
    expect(turns(orders, views, 1)).toEqual([1 - quick]);
  });

  it("stay the turn of a view until its own has come", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5)]];
    const place = orders.turn(views, 1, 4);
    expect(orders.turn(views, 1, 4)).toBe(place);
    expect(orders.take(key(at(77)), new Uint32Array(2048), 10)).toBe(false);
    expect(orders.at(place)).toBeUndefined();
  });

  it("are copies, cut to whole rows", () => {
    const [orders, views]: [ViewOrders, Views] = [new ViewOrders(), [at(0), at(5)]];
    const lent = new Uint32Array(3 * 2048).fill(7);
    const place = orders.turn(views, 1, 4);
    orders.take(key(views[place]), lent, 2049);
    lent.fill(0);
    expect(orders.at(place)?.ids).toEqual(new Uint32Array(2 * 2048).fill(7));
  });

  it("are one for two eyes", () => {
    expect(areEyes([at(0), at(0.06)], 3)).toBe(true);
    expect(areEyes([at(0)], 3)).toBe(true);
    expect(areEyes([at(0), at(2)], 3)).toBe(false);
  });
});
