// The size of moving pictures that holds a frame rate, as in embed-demo/native.

const PLANNED = 0.85;
const STEP = 1 / 32;
const NEWEST = 0.3;

/** Chooses the fraction of width and height to render, from the measured cost of pictures. */
export class Pace {
  #pixel = null;
  scale = 0.25;

  constructor(fps) {
    this.budget = (1000 * PLANNED) / fps;
  }

  /** Rendering `pixels` for a canvas of `all` pixels took `ms`. */
  rendered(pixels, all, ms) {
    const now = ms / pixels;
    // Twice the cost is a different place, not noise.
    const known = this.#pixel !== null && now < 2 * this.#pixel ? this.#pixel : now;
    this.#pixel = known + NEWEST * (now - known);
    const wanted = Math.sqrt(this.budget / (Math.max(this.#pixel, 1e-9) * all));
    const stepped = Math.floor(wanted / STEP) * STEP;
    // One step up only if it is well within reach, or the scale would oscillate.
    const isNear = stepped > this.scale && wanted < this.scale + 1.5 * STEP;
    if (!isNear) this.scale = Math.min(Math.max(stepped, STEP), 1);
  }
}
