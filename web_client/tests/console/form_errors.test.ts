import { describe, expect, it } from "vitest";
import { fieldOf, reasonOf } from "../../src/console/form_field";

describe("fieldOf", () => {
  it.each([
    ["title", "body-invalid", "title"],
    ["hold_out.3", "body-invalid", "hold_out"],
    ["", "capture-invalid", "capture"],
    ["", "capture-outside", "capture"],
    ["config.seed", "config-invalid", null],
    ["", "storage-full", null],
  ])("of %j and %s", (field, code, found) => {
    expect(fieldOf({ field, code })).toBe(found);
  });
});

it("says the reason beside the field without its name", () => {
  const message = "The server answered 422: title: is empty; give one line of text";
  expect(reasonOf({ message, field: "title" })).toBe("Is empty; give one line of text");
  expect(reasonOf({ message: "The server cannot be reached.", field: "" })).toBe("The server cannot be reached.");
  expect(reasonOf({ message: "The server answered 422: cam03.mp4: truncated", field: "capture" })).toBe(
    "cam03.mp4: truncated",
  );
});
