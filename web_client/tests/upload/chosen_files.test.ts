import { createHash } from "node:crypto";
import { describe, expect, it } from "vitest";
import { arranged, fromDrop, fromPicker, uploadKey } from "../../src/upload/chosen_files";

const file = (path: string, size = 3) => ({ path, file: new File(["x".repeat(size)], path.split("/").at(-1) ?? "") });
const paths = (all: ReturnType<typeof file>[]) => arranged(all).files.map(({ path }) => path);

describe("arranged", () => {
  it("takes the folder that holds everything for the capture's name", () => {
    const chosen = arranged([file("studio/cam00.mp4"), file("studio/sparse/0/cameras.txt")]);
    expect(chosen.name).toBe("studio");
    expect(chosen.files.map(({ path }) => path)).toEqual(["cam00.mp4", "sparse/0/cameras.txt"]);
  });

  it("keeps paths where there is no such folder", () => {
    expect(paths([file("a/1.png"), file("b/1.png")])).toEqual(["a/1.png", "b/1.png"]);
    expect(paths([file("a.mp4"), file("sub/b.mp4")])).toEqual(["a.mp4", "sub/b.mp4"]);
  });

  it("leaves out what is hidden and what file managers leave behind", () => {
    const junk = ["s/.DS_Store", "s/.git/config", "s/Thumbs.db", "__MACOSX/s/._a.mp4", "s/desktop.ini"];
    expect(paths([...junk.map((path) => file(path)), file("s/a.mp4")])).toEqual(["a.mp4"]);
    expect(arranged(junk.map((path) => file(path))).files).toEqual([]);
  });

  it("composes names, as the server does", () => {
    expect(paths([file("s/Kamera A\u0308.mp4")])).toEqual(["Kamera Ä.mp4"]);
  });
});

it("takes several files without a folder", () => {
  const chosen = fromPicker([new File(["a"], "cam1.mp4"), new File(["b"], "cam0.mp4")]);
  expect(chosen.files.map(({ path }) => path)).toEqual(["cam0.mp4", "cam1.mp4"]);
  expect(chosen.name).toMatch(/^Capture of \d{4}-\d\d-\d\d$/);
});

it("makes the key of docs/upload.md, which is that of hgs submit", () => {
  const files = [file("b.mp4", 12), file("ﬀ.png", 2), file("😀.png", 1), file("a/ä.png", 5)];
  const lines = "a/ä.png\t5\nb.mp4\t12\nﬀ.png\t2\n😀.png\t1\n"; // by the bytes of UTF-8, not by UTF-16
  expect(uploadKey(files)).toBe(createHash("sha256").update(lines).digest("hex"));
});

/** A folder as browsers tell of it: some entries at a time. */
function folderEntry(name: string, inside: FileSystemEntry[]): FileSystemEntry {
  const createReader = () => {
    const left = [...inside];
    return { readEntries: (tell: (some: FileSystemEntry[]) => void) => tell(left.splice(0, 2)) };
  };
  return { name, isFile: false, createReader } as unknown as FileSystemEntry;
}

const fileEntry = (name: string): FileSystemEntry =>
  ({
    name,
    isFile: true,
    file: (tell: (file: File) => void) => tell(new File(["x"], name)),
  }) as unknown as FileSystemEntry;

it("takes a dropped folder with everything in it", async () => {
  const pictures = Array.from({ length: 5 }, (_, k) => fileEntry(`${k}.png`));
  const dropped = folderEntry("studio", [fileEntry("poses.npy"), folderEntry("cam00", pictures), fileEntry(".hidden")]);
  const items = [{ webkitGetAsEntry: () => dropped }, { webkitGetAsEntry: () => null }];
  const chosen = await fromDrop(items as unknown as DataTransferItemList);
  expect(chosen.name).toBe("studio");
  expect(chosen.files.map(({ path }) => path)).toEqual([...pictures.map(({ name }) => `cam00/${name}`), "poses.npy"]);
});
