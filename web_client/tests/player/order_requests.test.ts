import { describe, expect, it } from "vitest";
import { OrderRequests } from "../../src/player/order_requests";

describe("the orders of a scene", () => {
  it("tell the moments of orders that others keep, whose splats must stay", () => {
    const orders = new OrderRequests({ order: () => {} }, { setOrder: () => {} });
    expect(orders.moments).toEqual([]);
    orders.others = [{ time: 1, from: 0.5, until: 1.5 }];
    expect(orders.moments).toEqual([{ time: 1, from: 0.5, until: 1.5 }]);
  });
});
