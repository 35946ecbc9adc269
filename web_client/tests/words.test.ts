import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, it } from "vitest";

/** The rules of tests/test_words.py for this package: docstrings that name their subject, comments that stand alone. */

const SRC = join(import.meta.dirname, "../src");

const CLAUSE = /\b(what|whatever|who|whom|whose|whoever)\b/i;
const DANGLING =
  /^(of|that|which|per|by|from|with|without|for|in|on|at|to|as|since|until|after|before|than|beside|under|over|where|when|while|whose|who|what)\b/i;

/** Docstrings, strings and regular expressions, which may hold slashes, and comments to the end of a line. */
const TOKENS =
  /\/\*\*(?<docstring>(?:(?!\*\/)[\s\S])*)\*\/|"(?:\\.|[^"\\\n])*"|`(?:\\.|[^`\\])*`|(?<=[(,=:]\s*)\/(?![*/])(?:\\.|\[[^\]\n]*\]|[^/\\\n[])+\/|\/\/ ?(?<comment>.*)/g;

interface Comment {
  readonly place: string;
  readonly text: string;
  readonly kind: "docstring" | "trailing" | "line";
}

const COMMENTS: readonly Comment[] = readdirSync(SRC, { recursive: true, encoding: "utf-8" })
  .filter((name) => name.endsWith(".ts"))
  .flatMap((name) => {
    const source = readFileSync(join(SRC, name), "utf-8");
    return [...source.matchAll(TOKENS)].flatMap(({ groups, index }) => {
      const { docstring, comment } = groups as { docstring?: string; comment?: string };
      const before = source.slice(0, index);
      const place = `${name}:${before.split("\n").length}`;
      if (docstring !== undefined) return { place, text: docstring.replaceAll(/\n\s*\* ?/g, "\n"), kind: "docstring" };
      if (comment === undefined) return [];
      return { place, text: comment, kind: /\S[^\n]*$/.test(before) ? "trailing" : "line" };
    }) as Comment[];
  });

const shown = ({ place, text }: Comment): string => `${place}: ${text.trim()}`;

it("finds the comments of the source", () => {
  const kinds = COMMENTS.map(({ kind }) => kind);
  for (const kind of ["docstring", "trailing", "line"]) expect(kinds).toContain(kind);
});

it("has docstrings whose first paragraph names its subject", () => {
  const first = (text: string) => text.split(/\n\s*\n|\n@/)[0];
  const found = COMMENTS.filter(({ kind, text }) => kind === "docstring" && CLAUSE.test(first(text)));
  expect(found.map(shown)).toEqual([]);
});

it("has trailing comments that are units or noun phrases", () => {
  const found = COMMENTS.filter(({ kind, text }) => kind === "trailing" && DANGLING.test(text));
  expect(found.map(shown)).toEqual([]);
});
