import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { ManifestError } from "../../src/codec/errors";
import { parseManifest } from "../../src/codec/manifest";

const VECTORS = new URL("../../../tests/vectors/", import.meta.url);

// biome-ignore lint/suspicious/noExplicitAny: the tests break the document on purpose
function json(name: string): any {
  return JSON.parse(readFileSync(new URL(name, VECTORS), "utf8"));
}

describe("parseManifest", () => {
  it("reads every field", () => {
    const manifest = parseManifest(json("manifest.json"));
    expect(manifest.frameRate).toBe(30);
    expect(manifest.cameras[0].worldToCamera[3]).toEqual([0, 0, 0, 1]);
    expect(manifest.static[1]).toMatchObject({ bytes: 200, splats: 20, box: { min: [-1, 0, 1], max: [1.5, 2, 3] } });
    expect(manifest.slices[1].needs).toEqual([manifest.slices[0].chunks[0].id]);
    expect(manifest.totals).toEqual({ splatsStatic: 30, splatsDynamic: 70, bytesStatic: 300, bytesDynamic: 700 });
    expect(manifest.training).toEqual({ psnr: 31.5 });
    expect(manifest.antialiased).toBe(true);
    expect(manifest.metresPerUnit).toBe(0.5);
    expect(manifest.live).toBeNull();
    expect(manifest.capturedSpace).toEqual({
      front: [0, 0, -1],
      azimuth: 0.7,
      elevation: [-0.25, 0.3],
      distance: [1, 2.5],
    });
  });

  it("takes a document without the optional fields for one of a scene that is not antialiased, of a size not known", () => {
    const { antialiased, metres_per_unit, ...document } = json("manifest.json");
    expect(antialiased).toBe(true);
    expect(parseManifest(document).antialiased).toBe(false);
    expect(metres_per_unit).toBe(0.5);
    expect(parseManifest(document).metresPerUnit).toBeNull();
  });

  it("leaves the captured space unknown where the document does not tell", () => {
    const { captured_space, ...document } = json("manifest.json");
    expect(parseManifest(document).capturedSpace).toBeNull();
    const { azimuth, ...dome } = captured_space;
    expect(azimuth).toBe(0.7);
    expect(parseManifest({ ...document, captured_space: dome }).capturedSpace?.azimuth).toBeNull();
  });

  it("takes cones as they stand, and refuses a start with the subject alone that is not true or false", () => {
    const { captured_space, ...document } = json("manifest.json");
    const read = (more: object) =>
      parseManifest({ ...document, captured_space: { ...captured_space, ...more } }).capturedSpace;
    expect(read({ cones: [[0, 0]], subject_only: true })).toMatchObject({ cones: [[0, 0]], subjectOnly: true });
    expect(() => read({ subject_only: 1 })).toThrow("subject_only");
  });

  it.each(json("invalid_manifest.json") as { at: (string | number)[]; value: unknown; field: string }[])(
    "names $field when it is $value",
    ({ at, value, field }) => {
      const document = json("manifest.json");
      const last = at[at.length - 1];
      const parent = at.slice(0, -1).reduce((node, key) => node[key], document);
      if (value === null) delete parent[last];
      else parent[last] = value;
      let error: unknown;
      try {
        parseManifest(document);
      } catch (caught) {
        error = caught;
      }
      expect(error).toBeInstanceOf(ManifestError);
      expect((error as ManifestError).path).toBe(field);
    },
  );
});
