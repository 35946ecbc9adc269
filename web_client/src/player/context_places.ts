/**
 * Which players of a page have a graphics context: a browser gives a page so many, and takes the oldest away from whoever has it
 * when there is one more. So those that nobody sees give theirs back, and then those that stand, and then the oldest.
 */

/** Chromium and Safari give 16; two are left for the page's own. */
const PLACES = 14;

/** How readily a player gives its context back: the higher, the sooner. */
export enum Readiness {
  /** It is seen and has no picture yet, or somebody waits for one. */
  Never,
  Playing,
  Standing,
  /** It is not seen, but has no picture yet: it wants the context again. */
  Loading,
  OutOfSight,
}

export interface Tenant {
  readonly seen: boolean;
  readonly readiness: Readiness;
  /** Take a context. */
  take(): void;
  /** Give it back, and keep the picture. */
  give(): void;
}

const holders: Tenant[] = []; // who has used it last comes last
const queue: Tenant[] = [];
/** Those in the queue that had to make room although they are seen: they take what is free, and nothing from others. */
const patient = new Set<Tenant>();

/** Ask for a context; returns whether the tenant has one now, else it is given one when it can be. */
export function claimContext(tenant: Tenant): boolean {
  if (remove(holders, tenant)) holders.push(tenant);
  else {
    patient.delete(tenant);
    if (!queue.includes(tenant)) queue.push(tenant);
    serve();
  }
  return holders.includes(tenant);
}

/** The tenant needs no context any more, and has given back what it had. */
export function leaveContext(tenant: Tenant): void {
  patient.delete(tenant);
  remove(queue, tenant);
  if (remove(holders, tenant)) serve();
}

/** The tenant is seen no more, or has its picture now: its context may be of more use to another. */
export function offerContext(tenant: Tenant): void {
  if (tenant.readiness === Readiness.OutOfSight) {
    if (patient.delete(tenant)) remove(queue, tenant);
    if (remove(holders, tenant)) tenant.give();
  }
  if (queue.length > 0) serve();
}

function serve(): void {
  const urgency = (one: Tenant) => (patient.has(one) ? 0 : one.seen ? 2 : 1);
  for (const next of [...queue].sort((a, b) => urgency(b) - urgency(a))) {
    if (holders.length >= PLACES) {
      if (patient.has(next)) return;
      const least = next.seen ? Readiness.Playing : Readiness.OutOfSight;
      const [other] = [...holders].sort((a, b) => b.readiness - a.readiness); // of equals the oldest
      if (other.readiness < least) return;
      remove(holders, other);
      if (other.readiness !== Readiness.OutOfSight) queue.push(other);
      if (other.readiness < Readiness.Loading) patient.add(other);
      other.give();
    }
    remove(queue, next);
    patient.delete(next);
    holders.push(next);
    next.take();
  }
}

/** Returns whether it was there. */
function remove(from: Tenant[], tenant: Tenant): boolean {
  const place = from.indexOf(tenant);
  if (place >= 0) from.splice(place, 1);
  return place >= 0;
}
