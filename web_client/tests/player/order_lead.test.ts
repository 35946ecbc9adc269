import { expect, it } from "vitest";
import { OrderLead } from "../../src/scene/order_requests";

it("is what most of the last few orders took", () => {
  const lead = new OrderLead();
  expect(lead.duration).toBe(0);
  for (const duration of [16, 17, 200, 16]) lead.note(duration);
  expect(lead.duration).toBe(17);
  for (const duration of [33, 33, 33]) lead.note(duration);
  expect(lead.duration).toBe(33);
});

it("does not believe a pause of the machine", () => {
  const lead = new OrderLead();
  lead.note(60_000);
  expect(lead.duration).toBe(250);
});
