import { describe, expect, it } from "vitest";
import { WaitingSplats } from "../../src/host/waiting_splats";

/** Notes in `calls` what comes. */
function sink(calls: unknown[][]) {
  return {
    mostRows: 16,
    allocate: (...rows: unknown[]) => calls.push(["allocate", ...rows]),
    writeStatics: (...splats: unknown[]) => calls.push(["statics", ...splats]),
    writeDynamics: (...splats: unknown[]) => calls.push(["dynamics", ...splats]),
    setOrder: (...order: unknown[]) => calls.push(["order", ...order]),
  };
}

const TEXELS = new Float32Array(4);
const IDS = new Uint32Array(2048);

describe("splats that wait", () => {
  it("go over once, as they came, the order last", () => {
    const [waiting, calls]: [WaitingSplats, unknown[][]] = [new WaitingSplats(() => 16), []];
    expect(waiting.empty).toBe(true);
    waiting.allocate(2, 3);
    waiting.setOrder(IDS, 5);
    waiting.writeStatics(0, TEXELS);
    waiting.writeDynamics([7], TEXELS, TEXELS);
    expect(waiting.empty).toBe(false);
    expect(waiting.flush(sink(calls))).toEqual([IDS, 5]);
    expect(calls).toEqual([
      ["allocate", 2, 3],
      ["statics", 0, TEXELS],
      ["dynamics", [7], TEXELS, TEXELS],
      ["order", IDS, 5],
    ]);
    expect(waiting.empty).toBe(true);
    expect(waiting.flush(sink(calls))).toBeNull();
    expect(calls).toHaveLength(4);
  });

  it("go over as they come once they may, and only orders wait", () => {
    const [waiting, calls]: [WaitingSplats, unknown[][]] = [new WaitingSplats(() => 16), []];
    waiting.allocate(2, 3);
    waiting.pass(sink(calls));
    waiting.setOrder(IDS, 5);
    waiting.writeStatics(0, TEXELS);
    expect(calls).toEqual([
      ["allocate", 2, 3],
      ["statics", 0, TEXELS],
    ]);
    waiting.flush(sink(calls));
    expect(calls.at(-1)).toEqual(["order", IDS, 5]);
    expect(calls).toHaveLength(3);
  });

  it("know the device only when they are asked for it", () => {
    let rows = 16;
    const waiting = new WaitingSplats(() => rows);
    rows = 32;
    expect(waiting.mostRows).toBe(32);
  });
});
