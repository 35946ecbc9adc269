/** What all hosts of tests have in common: splats that are heard, and frames until a promise is fulfilled. */

export const encode = (bytes) => {
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return btoa(text);
};

const TYPES = ["manifest", "firstpicture", "ready", "play", "pause", "seeked", "ended", "volumechange", "error"];

/** A host draws a frame by `draw()`. */
export class DrawnHost {
  heard = [];

  /** Note the events of the splats; `listen` has a listener called with the details of a type. */
  hear(listen) {
    for (const type of TYPES) listen(type, (detail) => this.heard.push(type === "error" ? detail.message : type));
  }

  /** Draw frame after frame until a promise is fulfilled. */
  async drawUntil(promise) {
    let done = false;
    const finish = () => { done = true; };
    promise.then(finish, finish);
    while (!done) {
      await new Promise(requestAnimationFrame);
      this.draw();
    }
    return promise;
  }

  /** Until all of what is to be seen at the playhead is drawn. */
  settled() {
    return this.drawUntil(this.splats.seek(this.splats.currentTime));
  }

  /** The pixels of a canvas that was drawn right now: rows from the top, RGBA. */
  pixelsOf(canvas) {
    const copy = new OffscreenCanvas(this.width, this.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return encode(copy.getImageData(0, 0, this.width, this.height).data);
  }
}
