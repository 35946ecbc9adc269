import { expect, it } from "vitest";
import { configRows } from "../../src/console/config_table";

it("shows a config of any shape, fields of a group together", () => {
  const config = {
    preset: "preview",
    train: { steps: 12000, rates: { rgb: 0.005, motion: 0.4 }, antialiased: true },
    hold_out: ["cam00", "cam01"],
    masks: null,
    empty: {},
    list: [],
    title: "",
  };
  expect(configRows(config)).toEqual([
    { group: [], name: "preset", value: "preview" },
    { group: [], name: "hold_out", value: "cam00, cam01" },
    { group: [], name: "masks", value: "none" },
    { group: [], name: "empty", value: "{}" },
    { group: [], name: "list", value: "none" },
    { group: [], name: "title", value: "none" },
    { group: ["train"], name: "steps", value: "12,000" },
    { group: ["train"], name: "antialiased", value: "yes" },
    { group: ["train", "rates"], name: "rgb", value: "0.005" },
    { group: ["train", "rates"], name: "motion", value: "0.4" },
  ]);
});

it("ends where nesting has no end", () => {
  let deep: Record<string, unknown> = { end: 1 };
  for (let i = 0; i < 50; i++) deep = { deeper: deep };
  expect(configRows(deep)).toHaveLength(1);
});
