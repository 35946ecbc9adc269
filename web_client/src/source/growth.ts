/** How the manifest of a scene that grows follows from the one before (docs/format.md, "Scenes that grow"). */

interface Chunk {
  readonly id: string;
}

/** A manifest as JSON, before anything of it has been checked. */
export interface ManifestDocument {
  readonly live?: number;
  readonly end: number;
  readonly static: readonly Chunk[];
  readonly segments: readonly unknown[];
  readonly slices: readonly { readonly chunks: readonly Chunk[] }[];
  readonly audio?: { readonly pieces?: readonly Chunk[] };
}

/** The later manifest that a message `grow` makes of one. */
export function grown({ live: _, ...earlier }: ManifestDocument, growth: ManifestDocument): ManifestDocument | null {
  if (!Array.isArray(growth.segments)) return null;
  return {
    ...earlier,
    ...growth,
    segments: [...earlier.segments, ...growth.segments],
    slices: [...earlier.slices, ...growth.slices],
  };
}

/** Whether a manifest is a later version of another one. */
export function continues(later: ManifestDocument, earlier: ManifestDocument): boolean {
  if (earlier.live === undefined || (later.live !== undefined && later.live <= earlier.live)) return false;
  const begins = (a: readonly unknown[], b: readonly unknown[]) =>
    JSON.stringify(a.slice(0, b.length)) === JSON.stringify(b);
  return (
    later.end >= earlier.end &&
    begins(later.segments, earlier.segments) &&
    begins(later.slices, earlier.slices) &&
    later.static.length === earlier.static.length &&
    begins(later.static, earlier.static)
  );
}
