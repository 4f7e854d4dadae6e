// The front end of the notebook widget: a small picture while something moves, the complete one at
// rest, as the web page has it. widget-build puts it and the page's modules into dist/widget.js.

import { watch } from "./gestures.js";
import { Orbit } from "./orbit.js";
import { Pace } from "./pace.js";
import { load } from "./pocketnerf.js";

/** Target rate of moving pictures per second. */
const FPS = 30;
/** Milliseconds of rest after which the complete picture starts. */
const SETTLES = 60;
/** The most pixels of a picture, however fine the screen is. */
const MOST_PIXELS = 1.5e6;

/** One place where the widget is shown; there may be several of one model. */
class View {
  #model;
  #el;
  #canvas = document.createElement("canvas");
  #context = this.#canvas.getContext("2d", { alpha: false });
  #message = document.createElement("p");
  #small = document.createElement("canvas");
  #pace = new Pace(FPS);
  #scene = null;
  #orbit = null;
  /** The camera as Python knows it, as text. */
  #known = null;
  #isMoving = false;
  /** What has changed so far, counted: a picture of an older count is out of date. */
  #changes = 0;
  /** Whether the hand has moved the camera since Python was told. */
  #isTurned = false;
  #isClosed = false;
  #settling = 0;
  #observer = new ResizeObserver(() => this.#resize());
  #listeners = {
    "change:camera": () => this.#follow(),
    "change:quality": () => this.#change(),
    "change:width": () => this.#place(),
    "change:height": () => this.#place(),
  };

  constructor(model, el) {
    this.#model = model;
    this.#el = el;
    el.classList.add("pocketnerf-view");
    this.#message.setAttribute("role", "alert");
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "img");
    this.#canvas.ariaLabel = "A radiance field is loading.";
    // Keys and menus of the notebook are not for whoever moves the camera.
    this.#canvas.dataset.lmSuppressShortcuts = "true";
    for (const kind of ["keydown", "contextmenu"]) {
      el.addEventListener(kind, (event) => event.defaultPrevented && event.stopPropagation());
    }
    el.append(this.#canvas, this.#message);
    watch(this.#canvas, {
      turn: (x, y) => this.#turn((orbit) => orbit.drag(x, y, this.#canvas.clientHeight)),
      shift: (x, y) => {
        const { clientWidth, clientHeight } = this.#canvas;
        this.#turn((orbit) => orbit.pull(x, y, clientWidth, clientHeight));
      },
      approach: (factor) => this.#turn((orbit) => orbit.approach(factor)),
      click() {},
      reset: () => this.#turn(() => (this.#orbit = this.#around(this.#scene.camera()))),
    });
    for (const [name, listener] of Object.entries(this.#listeners)) model.on(name, listener);
    this.#place();
    this.#observer.observe(this.#canvas);
    this.#open();
  }

  async #open() {
    try {
      const scene = await load(this.#model.get("_file"));
      if (this.#isClosed) return scene.close();
      this.#scene = scene;
      const { kind, name } = scene.info;
      const what = `${name || "A radiance field"} (${kind})`;
      this.#canvas.ariaLabel = `${what}, seen from a camera that can be moved`;
      this.#follow();
    } catch (error) {
      this.#say(error);
    }
  }

  close() {
    this.#isClosed = true;
    clearTimeout(this.#settling);
    this.#observer.disconnect();
    for (const [name, listener] of Object.entries(this.#listeners)) this.#model.off(name, listener);
    this.#scene?.close();
  }

  /** Width and height of pictures as Python has them: those of its camera. */
  get #size() {
    return ["width", "height"].map((name) => this.#model.get(name));
  }

  #place() {
    const [width, height] = this.#size;
    this.#canvas.style.width = `${width}px`;
    this.#canvas.style.aspectRatio = `${width} / ${height}`;
    this.#change();
  }

  #resize() {
    const { clientWidth, clientHeight } = this.#canvas;
    if (!clientWidth || !clientHeight) return;
    const most = Math.sqrt(MOST_PIXELS / (clientWidth * clientHeight));
    const by = Math.min(devicePixelRatio, 2, most);
    const sides = [clientWidth, clientHeight];
    const [width, height] = sides.map((side) => Math.max(1, Math.round(side * by)));
    if (width === this.#canvas.width && height === this.#canvas.height) return;
    // Resizing clears a canvas: the old picture is shown until there is a new one.
    [this.#small.width, this.#small.height] = [this.#canvas.width, this.#canvas.height];
    this.#small.getContext("2d").drawImage(this.#canvas, 0, 0);
    [this.#canvas.width, this.#canvas.height] = [width, height];
    this.#context.drawImage(this.#small, 0, 0, width, height);
    this.#change();
  }

  /** Shows what Python's camera sees, unless that is the one it was told of. */
  #follow() {
    const camera = this.#model.get("camera");
    const text = JSON.stringify(camera);
    if (!this.#scene || text === this.#known) return;
    this.#known = text;
    this.#isTurned = false;
    this.#orbit = this.#around(camera);
    this.#change();
  }

  /** Turns that start at a camera. */
  #around(camera) {
    const info = { ...this.#scene.info, camera: { ...this.#scene.info.camera, pose: camera.pose } };
    return new Orbit({ info, camera: (width, height) => resized(camera, width, height) });
  }

  #turn(how) {
    if (!this.#orbit) return;
    how(this.#orbit);
    this.#isTurned = true;
    this.#change();
  }

  #tell() {
    this.#isTurned = false;
    const camera = this.#orbit.camera(...this.#size);
    // Python's numbers have 32 bits: what comes back from it is the same.
    const { width, height } = camera;
    const [focal, center, pose] = [camera.focal, camera.center, camera.pose].map((list) => [
      ...Float32Array.from(list),
    ]);
    const told = { width, height, focal, center, pose };
    this.#known = JSON.stringify(told);
    this.#model.set("camera", told);
    this.#model.save_changes();
  }

  #change() {
    if (!this.#orbit) return;
    this.#changes += 1;
    this.#canvas.dataset.state = "moving";
    clearTimeout(this.#settling);
    if (!this.#isMoving) this.#move();
  }

  /** Renders small pictures while something changes, then the complete one. */
  async #move() {
    this.#isMoving = true;
    for (let shown = 0; shown !== this.#changes && !this.#isClosed; ) {
      shown = this.#changes;
      if (this.#isTurned) this.#tell();
      try {
        await this.#paintSmall();
      } catch (error) {
        this.#say(error);
      }
      // At most one per frame of the screen.
      await new Promise(requestAnimationFrame);
    }
    this.#isMoving = false;
    if (!this.#isClosed) this.#settling = setTimeout(() => this.#settle(), SETTLES);
  }

  async #paintSmall() {
    const { width, height } = this.#canvas;
    const [w, h] = [width, height].map((side) => Math.max(1, Math.round(side * this.#pace.scale)));
    const begun = performance.now();
    const image = await this.#scene.render(this.#camera(w, h), { quality: 0 });
    if (!image) return;
    this.#pace.rendered(w * h, width * height, performance.now() - begun);
    [this.#small.width, this.#small.height] = [w, h];
    this.#small.getContext("2d").putImageData(image, 0, 0);
    this.#context.drawImage(this.#small, 0, 0, this.#canvas.width, this.#canvas.height);
  }

  async #settle() {
    const { width, height } = this.#canvas;
    const wanted = this.#changes;
    const isCurrent = () => wanted === this.#changes;
    const onTile = (tile, x, y) => isCurrent() && this.#context.putImageData(tile, x, y);
    const quality = this.#model.get("quality") ?? undefined;
    try {
      const image = await this.#scene.render(this.#camera(width, height), { onTile, quality });
      if (!image || !isCurrent()) return;
      this.#say();
      this.#canvas.dataset.state = "rest";
    } catch (error) {
      this.#say(error);
    }
  }

  #camera(width, height) {
    return stretched(this.#orbit.camera(...this.#size), width, height);
  }

  #say(error) {
    // Errors of what was closed do not matter.
    if (!this.#isClosed) this.#message.textContent = error?.message ?? "";
  }
}

/** The same view at about the same aspect. */
function stretched(camera, width, height) {
  const by = [width / camera.width, height / camera.height];
  const times = (numbers) => numbers.map((v, i) => v * by[i]);
  return { ...camera, width, height, focal: times(camera.focal), center: times(camera.center) };
}

/** As wide a view, as `Camera.resized` of Python has it. */
function resized(camera, width, height) {
  const by = width / camera.width;
  const [x, y] = camera.center;
  const center = [by * x, by * y + 0.5 * (height - by * camera.height)];
  return { ...camera, width, height, focal: camera.focal.map((v) => v * by), center };
}

function render({ model, el }) {
  const view = new View(model, el);
  return () => view.close();
}

export default { render };
