// How large a picture may be while things move: as the window of embed-demo/native chooses.

const PLANNED = 0.85;
const STEP = 1 / 32;
const NEWEST = 0.3;

/** Chooses the part of the width and height that is rendered, by what pictures have cost. */
export class Pace {
  #pixel = null;
  scale = 0.25;

  constructor(fps) {
    this.budget = (1000 * PLANNED) / fps;
  }

  /** So many pixels took so many milliseconds, for a canvas of so many. */
  rendered(pixels, all, ms) {
    const now = ms / pixels;
    // Twice as much all of a sudden is another place, not noise.
    const known = this.#pixel !== null && now < 2 * this.#pixel ? this.#pixel : now;
    this.#pixel = known + NEWEST * (now - known);
    const wanted = Math.sqrt(this.budget / (Math.max(this.#pixel, 1e-9) * all));
    const stepped = Math.floor(wanted / STEP) * STEP;
    // One step up only where it is well within reach, or it would go up and down.
    const isNear = stepped > this.scale && wanted < this.scale + 1.5 * STEP;
    if (!isNear) this.scale = Math.min(Math.max(stepped, STEP), 1);
  }
}
