import { describe, expect, it, vi } from "vitest";
import { OrderRequests } from "../../src/scene/order_requests";

describe("the orders of a scene", () => {
  it("tell the moments of orders that others keep, whose splats must stay", () => {
    const orders = new OrderRequests({ order: () => {} }, { setOrder: () => {} });
    expect(orders.moments).toEqual([]);
    orders.others = [{ time: 1, from: 0.5, until: 1.5 }];
    expect(orders.moments).toEqual([{ time: 1, from: 0.5, until: 1.5 }]);
  });

  it("are asked for anew where the budget of splats is another one", () => {
    const order = vi.fn();
    const orders = new OrderRequests({ order }, { setOrder: () => {} });
    const depth = { kind: "planar", x: 0, y: 0, z: 1, offset: 0, near: 0.1 } as const;
    const key = { depth, frustum: null, exact: true, time: 0, from: 0, until: 0, version: 1, budget: Infinity };
    for (const budget of [Infinity, Infinity, 100, 100, Infinity]) {
      orders.want({ ...key, budget });
      if (!orders.shows({ ...key, budget }))
        orders.receive({ ids: new Uint32Array(2048), count: 1, dynamic: 0, sortTime: 1 });
    }
    expect(order.mock.calls.map(([{ budget }]) => budget)).toEqual([Infinity, 100, Infinity]);
  });
});
