/** Opens one viewer, by `?viewer=`, on the files of `data/`, and offers its bench to the script outside. */

import "./frames";
import { Bench } from "./bench";
import type { BenchCamera, OpenViewer } from "./viewer";

declare global {
  interface Window {
    bench?: Bench;
  }
}

/** Each is a bundle of its own. */
const VIEWERS: Readonly<Record<string, () => Promise<OpenViewer>>> = {
  hgs: async () => (await import("./hgs")).openHgs("high"),
  "hgs-8bit": async () => (await import("./hgs")).openHgs("medium"),
  "hgs-budget": async () => (await import("./hgs")).openHgs("high", 0.5),
  playcanvas: async () => (await import("./playcanvas")).openPlayCanvas,
  babylon: async () => (await import("./babylon")).openBabylon,
  spark: async () => (await import("./spark")).openSpark,
  "gaussian-splats-3d": async () => (await import("./gaussian_splats_3d")).openGaussianSplats3D,
};

const query = new URLSearchParams(location.search);
const camera = JSON.parse(query.get("camera") ?? "") as BenchCamera;
const [width, height, splats] = ["width", "height", "splats"].map((name) => Number(query.get(name)));
const host = document.getElementById("host") as HTMLElement;
host.style.width = `${width}px`;
host.style.height = `${height}px`;
const open = await VIEWERS[query.get("viewer") ?? ""]();
const viewer = await open({ host, width, height, camera, splats, files: new URL("data/", location.href) });
window.bench = new Bench(viewer, camera, width, height);
