/**
 * The distribution of graphics contexts among a page's players: a browser allows a number of them, and takes the oldest
 * away for each one more. So players out of sight return theirs first, then paused ones, then the oldest.
 */

/** Chromium and Safari allow 16; two are left for the page itself. */
const PLACES = 14;

/** Readiness of a player to return its context: the higher, the sooner. */
export const Readiness = {
  /** Visible without a picture, or with a pending request for one. */
  Never: 0,
  Playing: 1,
  Standing: 2,
  /** Out of sight without a picture: it needs the context again. */
  Loading: 3,
  OutOfSight: 4,
} as const;

export type Readiness = (typeof Readiness)[keyof typeof Readiness];

export interface Tenant {
  readonly seen: boolean;
  readonly readiness: Readiness;
  /** Take a context. */
  take(): void;
  /** Return it, and keep the picture. */
  give(): void;
}

const holders: Tenant[] = []; // most recent user last
const queue: Tenant[] = [];
/** Visible tenants in the queue that had to make room: they take free contexts, and no others. */
const patient = new Set<Tenant>();

/** Request a context; returns whether the tenant has one now. Otherwise it gets one later. */
export function claimContext(tenant: Tenant): boolean {
  if (remove(holders, tenant)) holders.push(tenant);
  else {
    patient.delete(tenant);
    if (!queue.includes(tenant)) queue.push(tenant);
    serve();
  }
  return holders.includes(tenant);
}

/** The tenant has returned its context, and needs none. */
export function leaveContext(tenant: Tenant): void {
  patient.delete(tenant);
  remove(queue, tenant);
  if (remove(holders, tenant)) serve();
}

/** The tenant is out of sight, or has its picture: its context may be of more use to another. */
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
      const [other] = [...holders].sort((a, b) => b.readiness - a.readiness); // the oldest of equals
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

/** Remove a tenant from a list; returns whether it was in it. */
function remove(from: Tenant[], tenant: Tenant): boolean {
  const place = from.indexOf(tenant);
  if (place >= 0) from.splice(place, 1);
  return place >= 0;
}
