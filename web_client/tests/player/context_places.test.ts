import { beforeEach, describe, expect, it, vi } from "vitest";
import type { Tenant } from "../../src/player/context_places";

let places: typeof import("../../src/player/context_places");

/** A player that notes what becomes of it. */
class Player implements Tenant {
  has = false;
  given = 0;

  constructor(
    public readiness: Tenant["readiness"],
    public seen = true,
  ) {}

  take(): void {
    this.has = true;
  }

  give(): void {
    this.has = false;
    this.given++;
  }
}

const some = (count: number, readiness: Tenant["readiness"], seen = true) =>
  Array.from({ length: count }, () => new Player(readiness, seen));
const having = (players: readonly Player[]) => players.flatMap(({ has }, i) => (has ? [i] : []));
const claim = (players: readonly Player[]) => {
  for (const one of players) places.claimContext(one);
};

beforeEach(async () => {
  vi.resetModules();
  places = await import("../../src/player/context_places");
});

describe("the contexts of a page", () => {
  it("are given while there are any", () => {
    const all = some(14, places.Readiness.Never);
    expect(all.map((one) => places.claimContext(one))).toEqual(Array(14).fill(true));
    expect(places.claimContext(new Player(places.Readiness.Never))).toBe(false);
  });

  it("come back from those that nobody sees, at once", () => {
    const [one] = some(1, places.Readiness.Playing);
    claim([one]);
    Object.assign(one, { seen: false, readiness: places.Readiness.OutOfSight });
    places.offerContext(one);
    expect([one.has, one.given]).toEqual([false, 1]);
    expect(places.claimContext(one)).toBe(true);
  });

  it("are taken from those that are out of sight, then load there, then stand, then play, the oldest first", () => {
    const { Playing, Standing, Loading, OutOfSight } = places.Readiness;
    const all = [...some(11, Playing), new Player(Standing), new Player(Loading, false), new Player(OutOfSight, false)];
    claim(all);
    claim(some(4, places.Readiness.Never));
    expect(having(all)).toEqual([1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
  });

  it("are not taken from who is seen by who is not", () => {
    const all = some(14, places.Readiness.Standing);
    claim(all);
    expect(places.claimContext(new Player(places.Readiness.Loading, false))).toBe(false);
    expect(having(all)).toHaveLength(14);
  });

  it("are given first to those that are seen", () => {
    const all = some(14, places.Readiness.Never);
    const [hidden, seen] = [new Player(places.Readiness.Loading, false), new Player(places.Readiness.Never)];
    claim([...all, hidden, seen]);
    places.leaveContext(all[0]);
    expect([hidden.has, seen.has]).toEqual([false, true]);
    places.leaveContext(all[1]);
    expect(hidden.has).toBe(true);
  });

  it("come back to those that had to make room, as soon as there is some, and not before", () => {
    const all = some(14, places.Readiness.Playing);
    const late = new Player(places.Readiness.Never);
    claim([...all, late]);
    expect(having(all)).not.toContain(0);
    late.readiness = places.Readiness.Playing;
    places.offerContext(late);
    expect(having(all)).not.toContain(0);
    places.leaveContext(all[5]);
    expect(having(all)).toContain(0);
  });

  it("are not kept for a player that is gone", () => {
    const all = some(14, places.Readiness.Never);
    const [gone, next] = some(2, places.Readiness.Never);
    claim([...all, gone, next]);
    places.leaveContext(gone);
    places.leaveContext(all[0]);
    expect([gone.has, next.has]).toEqual([false, true]);
  });
});
