/**
 * The public interface of the package that `npm run build:package` has written, to api.txt: `npm run api`. First the names of
 * each entry and its additions to other modules, then all declarations that these lead to, without comments and private members.
 * `npm run api -- FILE` writes another file.
 */

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import type { Node } from "typescript/unstable/ast";
import { isIdentifier, isModuleDeclaration, isSourceFile, isVariableDeclaration } from "typescript/unstable/ast/is";
import { API, type Symbol as Meaning, SymbolFlags } from "typescript/unstable/sync";

const FOLDER = `${resolve("dist/types")}/`;
const CONFIG = resolve("node_modules/.scripts/api.tsconfig.json");

const { name, exports } = JSON.parse(readFileSync("package.json", "utf-8"));
const entries = Object.entries<{ types?: string }>(exports).flatMap(([entry, { types }]) =>
  types === undefined ? [] : [{ entry: name + entry.slice(1), file: resolve(types) }],
);
const compilerOptions = {
  module: "nodenext",
  target: "es2022",
  types: ["webxr"],
  typeRoots: [resolve("node_modules/@types")],
};
mkdirSync(resolve(CONFIG, ".."), { recursive: true });
writeFileSync(CONFIG, JSON.stringify({ compilerOptions, files: entries.map(({ file }) => file) }));
const api = new API();
const [project] = api.updateSnapshot({ openProjects: [CONFIG] }).getProjects();
const { checker, program } = project;

/** A declaration's text by itself. */
function shown(node: Node): string {
  const whole = isVariableDeclaration(node) ? node.parent.parent : node;
  const lines = whole
    .getText()
    .replaceAll(/\/\*\*[\s\S]*?\*\//g, "")
    .split("\n");
  const open = lines.filter((line) => /\S/.test(line) && !/^\s*(#private|private )/.test(line));
  return open.join("\n").replace(/^export (declare )?|^declare (?=const)/, "");
}

/** The symbol itself, where a name stands for one of another file. */
function meant(symbol: Meaning): Meaning {
  return symbol.flags & SymbolFlags.Alias ? checker.getAliasedSymbol(symbol) : symbol;
}

/** The declarations of symbols that stand at the top of the package's files. */
function declared(symbols: readonly (Meaning | undefined)[]): Node[] {
  const nodes = symbols.flatMap((symbol) => (symbol ? meant(symbol).declarations : []));
  const own = nodes.map((handle) => handle.resolve(project)).filter((node) => node !== undefined);
  return own.filter((node) => {
    if (!node.getSourceFile().fileName.startsWith(FOLDER) || isModuleDeclaration(node)) return false;
    const whole = isVariableDeclaration(node) ? node.parent.parent : node;
    return isSourceFile(whole.parent);
  });
}

/** The declarations that the names in a node lead to. */
function ledTo(node: Node): Node[] {
  const names: Node[] = [];
  const visit = (child: Node): void => {
    if (isIdentifier(child)) names.push(child);
    child.forEachChild(visit);
  };
  visit(node);
  return declared(checker.getSymbolAtLocation(names));
}

const report = ["The public interface of the package, written by `npm run api`."];
const all = new Map<string, Node>();
const collect = (nodes: readonly Node[]): void => {
  for (const node of nodes) {
    const key = `${node.getSourceFile().fileName}:${node.getStart()}`;
    if (all.has(key)) continue;
    all.set(key, node);
    collect(ledTo(node));
  }
};
for (const { entry, file } of entries) {
  const source = program.getSourceFile(file);
  const module = source && checker.getSymbolAtLocation(source);
  if (!module) throw new Error(`${file} is no module: run npm run build:package`);
  const symbols = checker.getExportsOfModule(module);
  const additions: Node[] = [];
  source.forEachChild((node) => void (isModuleDeclaration(node) && additions.push(node)));
  report.push("", `# ${entry}`, "", ...symbols.map(({ name }) => name).sort(), ...additions.map(shown));
  collect([...declared(symbols), ...additions.flatMap(ledTo)]);
}
const texts = [...all.values()].map(shown).sort();
writeFileSync(process.argv[2] ?? "api.txt", [...report, "", "# Declarations", "", texts.join("\n\n"), ""].join("\n"));
api.close();
