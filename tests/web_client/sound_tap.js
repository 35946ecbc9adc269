// Notes when each click leaves the page's sound, before any page's script runs: window.clicks, milliseconds of the page's clock.
(() => {
  const tap = `registerProcessor("tap", class extends AudioWorkletProcessor {
    quiet = 0;
    process([[samples]]) {
      for (const [i, sample] of (samples ?? []).entries()) {
        this.quiet++;
        if (Math.abs(sample) < 0.1) continue;
        if (this.quiet > sampleRate / 20) this.port.postMessage(currentTime + i / sampleRate);
        this.quiet = 0;
      }
      return true;
    }
  });`;
  window.clicks = [];
  const Original = AudioContext;
  window.AudioContext = class extends Original {
    constructor(...options) {
      super(...options);
      window.context = this;
      const address = URL.createObjectURL(new Blob([tap], { type: "text/javascript" }));
      this.tap = this.audioWorklet.addModule(address).then(() => {
        const node = new AudioWorkletNode(this, "tap");
        node.port.onmessage = ({ data }) => {
          const { contextTime, performanceTime } = this.getOutputTimestamp();
          window.clicks.push(performanceTime + 1000 * (data - contextTime));
        };
        return node;
      });
    }
  };
  const { connect } = AudioNode.prototype;
  AudioNode.prototype.connect = function (to, ...rest) {
    if (to instanceof AudioDestinationNode) this.context.tap?.then((node) => connect.call(this, node));
    return connect.call(this, to, ...rest);
  };
})();
