import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
import { Scene } from "three";
import { threeHost } from "./three_host";
import type { OpenViewer } from "./viewer";

export const openSpark: OpenViewer = async (request) => {
  const { renderer, camera, look, gl } = threeHost(request);
  const scene = new Scene();
  const spark = new SparkRenderer({ renderer });
  const mesh = new SplatMesh({ url: new URL("scene.ply", request.files).href });
  scene.add(spark, mesh);
  await mesh.initialized;
  return {
    gl,
    look,
    draw: () => renderer.render(scene, camera),
    busy: () => spark.sorting || spark.sortDirty,
  };
};
