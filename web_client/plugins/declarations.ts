import { readdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";

/** Give the imports of declarations in a folder the names of files, without which Node's way of finding modules fails. */
export async function nameFiles(folder: string): Promise<void> {
  for (const entry of await readdir(folder, { recursive: true, withFileTypes: true })) {
    if (!entry.name.endsWith(".d.ts")) continue;
    const path = join(entry.parentPath, entry.name);
    const text = await readFile(path, "utf-8");
    await writeFile(path, text.replace(/(\b(?:from|import)\s*\(?\s*"\.[^"]+?)(?:\.js)?"/g, '$1.js"'));
  }
}
