/** The chosen or dropped files of one capture, with their paths below its folder. */

import { sha256 } from "@noble/hashes/sha2.js";
import { bytesToHex } from "@noble/hashes/utils.js";

export interface ChosenFile {
  /** Path below the capture's folder, in NFC, with "/". */
  readonly path: string;
  readonly file: File;
}

export interface Chosen {
  /** Name of the capture. */
  readonly name: string;
  readonly files: readonly ChosenFile[];
}

// Leftovers of file managers; no capture needs them.
const JUNK = /^(\..*|__MACOSX|thumbs\.db|desktop\.ini)$/i;

/** The files of a picked folder, or several picked files. */
export function fromPicker(files: Iterable<File>): Chosen {
  return arranged([...files].map((file) => ({ path: file.webkitRelativePath || file.name, file })));
}

/** The dropped files, those in folders included. To be called before the drop event ends. */
export function fromDrop(items: DataTransferItemList): Promise<Chosen> {
  const entries = [...items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  return Promise.all(entries.map((entry) => filesOf(entry, ""))).then((found) => arranged(found.flat()));
}

/** The files without hidden ones, and without the one folder around everything, which names the capture. */
export function arranged(all: readonly ChosenFile[]): Chosen {
  const files = all
    .map(({ path, file }) => ({ path: path.normalize("NFC"), file }))
    .filter(({ path }) => !path.split("/").some((part) => JUNK.test(part)));
  const tops = new Set(files.map(({ path }) => path.split("/")[0]));
  const [top] = tops;
  const nested = tops.size === 1 && files.every(({ path }) => path.includes("/"));
  if (!nested) return { name: files.length > 0 ? nameOf(files) : "", files: sorted(files) };
  return { name: top, files: sorted(files.map(({ path, file }) => ({ path: path.slice(top.length + 1), file }))) };
}

/** The server's key for the same upload: docs/upload.md, Upload, 1. */
export function uploadKey(files: readonly ChosenFile[]): string {
  const encoder = new TextEncoder();
  const lines = sorted(files).map(({ path, file }) => `${path}\t${file.size}\n`);
  return bytesToHex(sha256(encoder.encode(lines.join(""))));
}

/** The files in the order of their paths' bytes in UTF-8, which is that of their code points. */
function sorted(files: readonly ChosenFile[]): ChosenFile[] {
  const keyed = files.map((file) => ({ file, key: new TextEncoder().encode(file.path) }));
  keyed.sort((a, b) => compareBytes(a.key, b.key));
  return keyed.map(({ file }) => file);
}

function compareBytes(a: Uint8Array, b: Uint8Array): number {
  const length = Math.min(a.length, b.length);
  for (let k = 0; k < length; k++) if (a[k] !== b[k]) return a[k] - b[k];
  return a.length - b.length;
}

/** A name for files without a folder: that of the only one, or the day. */
function nameOf(files: readonly ChosenFile[]): string {
  if (files.length === 1) return files[0].path.replace(/\.[^.]*$/, "");
  return `Capture of ${new Date().toISOString().slice(0, 10)}`;
}

async function filesOf(entry: FileSystemEntry, above: string): Promise<ChosenFile[]> {
  const path = above + entry.name;
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    return [{ path, file }];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const found: ChosenFile[] = [];
  for (;;) {
    // a reader returns a hundred entries at a time
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return found;
    for (const inner of some) found.push(...(await filesOf(inner, `${path}/`)));
  }
}
