import { expect, it } from "vitest";
import { Speed } from "../../src/upload/speed";

it("says nothing before it knows, and then what the last seconds say", () => {
  const speed = new Speed();
  for (let time = 0; time < 2; time++) speed.note(100 * time, time);
  expect(speed.perSecond()).toBeNull();
  for (let time = 2; time <= 60; time++) speed.note(100 * time, time);
  for (let time = 61; time <= 90; time++) speed.note(6000 + 10 * (time - 60), time);
  expect(speed.perSecond()).toBeCloseTo(10);
  speed.reset();
  expect(speed.perSecond()).toBeNull();
});

it("knows no speed while nothing goes", () => {
  const speed = new Speed();
  for (let time = 0; time < 30; time++) speed.note(5, time);
  expect(speed.perSecond()).toBeNull();
});
