// Splats in React Three Fiber 9, by WebGPURenderer; React mounts and unmounts them.
import { Canvas } from "@react-three/fiber";
import { useEffect, useState } from "react";
import { createRoot } from "react-dom/client";
import { WebGPURenderer } from "three/webgpu";
import { HgsScene } from "@hgs/player/three-webgpu";

function Splats({ src }) {
  const [splats, setSplats] = useState(null);
  useEffect(() => {
    const made = new HgsScene({ src, loop: true, autoplay: true });
    made.addEventListener("manifest", () => setSplats(made));
    return () => made.dispose();
  }, [src]);
  return splats && <primitive object={splats} dispose={null} />;
}

async function gl(options) {
  const renderer = new WebGPURenderer(options);
  await renderer.init();
  return renderer;
}

createRoot(document.querySelector("main")).render(
  <Canvas gl={gl} camera={{ position: [0, 0, -3] }}>
    <Splats src="scene/manifest.json" />
  </Canvas>,
);
