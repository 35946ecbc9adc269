/** The splats that have rows of an attribute, by their forms (docs/format.md, "Attributes"). */

import { type Attribute, attributeOf, FIFTH, hasRow, TURNS } from "./attributes";
import type { Container, Stream } from "./chunk";
import { ChunkError } from "./errors";
import { readStream } from "./streams";

const FORMS = 16;

/** Members of an attribute; reused for every chunk. */
let scratch = new Uint32Array(0);

export class Forms {
  private readonly forms: Uint8Array;
  /** Number of splats of each form. */
  private readonly splatsOf = new Uint32Array(FORMS);

  /** Read the forms of a chunk; without a stream of forms all are 0. Throws ChunkError. */
  constructor(
    private readonly container: Container,
    stream: Stream | undefined,
  ) {
    const { version, count } = container;
    this.forms = new Uint8Array(count);
    if (!stream) {
      this.splatsOf[0] = count;
      return;
    }
    // A form is its code, not its value.
    const codes = new Float32Array(count);
    const grid = { ...stream.grid, step: 1, zeros: [0] };
    readStream({ ...stream, grid }, attributeOf("form"), count, { values: codes, first: 0, stride: 1 });
    const largest = TURNS + 3 + (version > 2 ? FIFTH : 0);
    for (let i = 0; i < count; i++) {
      const form = codes[i];
      if (form >= FIFTH && (form > largest || (form & 3) !== 3)) {
        const expected = `at most ${largest}, of order 3 below the fifth`;
        throw new ChunkError(stream.planes[0].at, `form of splat ${i}`, form, expected);
      }
      this.forms[i] = form;
      this.splatsOf[form]++;
    }
  }

  /** Number of rows of an attribute. */
  rowsOf(attribute: Attribute): number {
    const { kind, count } = this.container;
    if (attribute.dynamicOnly && kind === "static") return 0;
    if (attribute.rowsOf === 0) return count;
    return this.splatsOf.reduce((sum, splats, form) => sum + (hasRow(attribute, form) ? splats : 0), 0);
  }

  /** The splats that have rows of a sparse attribute, in order, until the next call. */
  membersOf(attribute: Attribute): Uint32Array {
    const { forms } = this;
    const has = Uint8Array.from({ length: FORMS }, (_, form) => (hasRow(attribute, form) ? 1 : 0));
    if (scratch.length < forms.length + 1) scratch = new Uint32Array(forms.length + 1); // one entry more
    const members = scratch;
    let found = 0;
    for (let i = 0; i < forms.length; i++) {
      members[found] = i;
      found += has[forms[i]];
    }
    return members.subarray(0, found);
  }
}
