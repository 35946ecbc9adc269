// A headset for a page under test, made of the emulator IWER: `headset.frame()` runs one frame of its session, and none
// comes by itself. Its eyes have pictures of their own, as real headsets do, with projections that the test chooses.
(() => {
  const { XRDevice, XRView, XRFrame, XRWebGLLayer, metaQuest3 } = IWER;
  const device = new XRDevice(metaQuest3, { stereoEnabled: true, ipd: 0.064 });
  device.installRuntime({ forceInstall: true });

  let skipped = 0; // ms
  const now = performance.now.bind(performance);
  performance.now = () => now() + skipped;

  let held = null; // callbacks for the next frame, from a session's beginning to its end
  const [request, cancel] = [requestAnimationFrame.bind(window), cancelAnimationFrame.bind(window)];
  window.requestAnimationFrame = (callback) => (held ? -held.push(callback) : request(callback));
  window.cancelAnimationFrame = (handle) => (handle < 0 && held ? delete held[-handle - 1] : cancel(handle));

  const system = navigator.xr;
  const requestSession = system.requestSession.bind(system);
  system.requestSession = async (mode, options) => {
    if (headset.refusal) throw new DOMException("refused by the test", headset.refusal);
    held = [];
    headset.session = await requestSession(mode, options);
    headset.session.addEventListener("end", () => {
      const rest = held;
      held = null;
      headset.session = null;
      for (const callback of rest) if (callback) request(callback);
    });
    return headset.session;
  };

  const own = (type, name, get) => {
    const original = Object.getOwnPropertyDescriptor(type.prototype, name);
    Object.defineProperty(type.prototype, name, { get() { return get(this) ?? original.get.call(this); } });
  };
  own(XRView, "projectionMatrix", (view) => headset.projections?.[view.eye]);
  const framebuffers = new WeakMap();
  own(XRWebGLLayer, "framebuffer", (layer) => {
    const gl = layer.context;
    if (!framebuffers.has(layer)) {
      const before = gl.getParameter(gl.FRAMEBUFFER_BINDING);
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, 2 * headset.width, headset.height);
      const framebuffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
      gl.bindFramebuffer(gl.FRAMEBUFFER, before);
      framebuffers.set(layer, framebuffer);
    }
    return framebuffers.get(layer);
  });
  const scales = new WeakMap();
  XRView.prototype.requestViewportScale = function (scale) {
    scales.set(this, scale);
  };
  XRWebGLLayer.prototype.getViewport = (view) => {
    const { width, height } = headset;
    const scale = scales.get(view) ?? 1;
    headset.drawn = [Math.round(width * scale), Math.round(height * scale)];
    return { x: view.eye === "right" ? width : 0, y: 0, width: headset.drawn[0], height: headset.drawn[1] };
  };
  const getViewerPose = XRFrame.prototype.getViewerPose;
  XRFrame.prototype.getViewerPose = function (space) {
    if (!headset.tracking) return null;
    const { transform, views } = getViewerPose.call(this, space);
    return { transform, views: headset.oneEye ? views.slice(0, 1) : views };
  };

  // What the page asks of its worker and of the graphics card, frame by frame.
  const asked = [];
  const NativeWorker = Worker;
  window.Worker = class extends NativeWorker {
    constructor(...args) {
      super(...args);
      this.addEventListener("message", ({ data }) => {
        if (data.type === "ordered") headset.orderOf = asked.shift();
      });
    }
    postMessage(message, ...rest) {
      if (message.type === "order") {
        asked.push(headset.frames);
        headset.budget = message.request.budget;
      }
      super.postMessage(message, ...rest);
    }
  };
  const draw = WebGL2RenderingContext.prototype.drawArraysInstanced; // the only one that draws splats
  WebGL2RenderingContext.prototype.drawArraysInstanced = function (...args) {
    headset.draws++;
    if (!headset.bare) draw.apply(this, args);
  };

  const drawFlat = WebGL2RenderingContext.prototype.drawArrays; // strips are the panel, rays and arrows
  WebGL2RenderingContext.prototype.drawArrays = function (mode, ...rest) {
    if (!headset.bare || mode !== this.TRIANGLE_STRIP) drawFlat.call(this, mode, ...rest);
  };

  const getParameter = WebGL2RenderingContext.prototype.getParameter;
  WebGL2RenderingContext.prototype.getParameter = function (name) {
    const value = getParameter.call(this, name);
    return this.isContextLost() ? [0, 0, 0, 0] : value; // IWER does not expect that a context is lost
  };

  const base64 = (bytes) => {
    let text = "";
    for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
    return btoa(text);
  };

  window.headset = {
    device,
    session: null,
    refusal: null, // name of the DOMException with which a session is refused
    tracking: true,
    oneEye: false,
    drawn: null, // [width, height] of an eye's picture in the last frame, pixels
    width: 256, // of an eye, pixels
    height: 256,
    projections: null, // { left, right }: 16 numbers by columns; null for those of IWER
    frames: 0,
    draws: 0, // of splats
    bare: false, // nothing is drawn but what is behind all
    budget: Infinity, // of the order that was asked for last, splats
    orderOf: 0, // the frame in which the newest order was asked for
    /** Let time pass without frames, milliseconds. */
    skip(time) {
      skipped += time;
    },
    /** Run one frame; returns how often splats were drawn in it. Throws if the page says that it drew, and none was seen. */
    frame() {
      headset.frames++;
      const [before, shown] = [headset.draws, hgs.state.framesDrawn];
      for (const callback of held.splice(0)) callback?.(performance.now());
      const draws = headset.draws - before;
      // Else a page that draws in another way would be waited for without end.
      if (draws === 0 && hgs.state.splats > 0 && hgs.state.framesDrawn > shown)
        throw new Error("the page drew splats by a call that the headset of this test does not count");
      return draws;
    },
    /** Run frames until the session has a picture. */
    async entered() {
      while (!held) await new Promise((resolve) => setTimeout(resolve, 1));
      // A frame of the page, asked for before the session had a layer, draws splats as well.
      while (headset.frame() === 0 || !headset.session?.renderState.baseLayer)
        await new Promise((resolve) => setTimeout(resolve, 1));
    },
    /** Wait until the worker has answered what it was asked. */
    async answered() {
      while (asked.length > 0) await new Promise((resolve) => setTimeout(resolve, 1));
    },
    /** The eyes' pictures after a frame: RGBA from the bottom row, in base64. */
    eyes() {
      const layer = headset.session.renderState.baseLayer;
      const { context: gl, framebuffer } = layer;
      const { width, height } = headset;
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      return [0, width].map((x) => {
        const pixels = new Uint8Array(4 * width * height);
        gl.readPixels(x, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return base64(pixels);
      });
    },
  };
})();
