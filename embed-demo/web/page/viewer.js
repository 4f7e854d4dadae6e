// The page: a small picture while something moves, the complete one at rest.

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

const [canvas, stage, message, figures] = ["picture", "stage", "message", "figures"].map((id) =>
  document.getElementById(id),
);
const context = canvas.getContext("2d", { alpha: false });
const small = document.createElement("canvas");
const pace = new Pace(FPS);
const asked = new URLSearchParams(location.search);

/** The scene that is shown, its view, and the name of its file. */
let shown = null;
let isMoving = false;
let hasChanged = false;
let settling = 0;

function change() {
  if (!shown) return;
  hasChanged = true;
  canvas.dataset.state = "moving";
  clearTimeout(settling);
  if (!isMoving) move();
}

/** Renders small pictures while something changes, then the complete one. */
async function move() {
  isMoving = true;
  while (hasChanged) {
    hasChanged = false;
    const { scene } = shown;
    try {
      await paintSmall(shown);
    } catch (error) {
      // Errors of a scene that was replaced do not matter.
      if (scene === shown.scene) say(error.message);
    }
    // At most one per frame of the screen.
    await new Promise(requestAnimationFrame);
  }
  isMoving = false;
  settling = setTimeout(settle, SETTLES);
}

async function paintSmall({ scene, orbit }) {
  const { width, height } = canvas;
  const [w, h] = [width, height].map((side) => Math.max(1, Math.round(side * pace.scale)));
  const begun = performance.now();
  const image = await scene.render(scaled(orbit.camera(width, height), w, h), { quality: 0 });
  if (!image || scene !== shown.scene) return;
  const ms = performance.now() - begun;
  pace.rendered(w * h, width * height, ms);
  [small.width, small.height] = [w, h];
  small.getContext("2d").putImageData(image, 0, 0);
  context.drawImage(small, 0, 0, canvas.width, canvas.height);
  reportPicture(`${ms.toFixed(0)} ms a frame at ${w} × ${h}, detail ${Math.round(100 * pace.scale)} %`);
}

/** The same view at another size. */
function scaled(camera, width, height) {
  const by = [width / camera.width, height / camera.height];
  const times = (numbers) => numbers.map((v, i) => v * by[i]);
  return { ...camera, width, height, focal: times(camera.focal), center: times(camera.center) };
}

async function settle() {
  const { scene, orbit } = shown;
  const { width, height } = canvas;
  const isCurrent = () => shown.scene === scene && !hasChanged;
  const onTile = (tile, x, y) => isCurrent() && context.putImageData(tile, x, y);
  try {
    const image = await scene.render(orbit.camera(width, height), { onTile });
    if (!image || !isCurrent()) return;
    reportPicture(`${scene.stats.ms.toFixed(0)} ms for the whole picture, ${width} × ${height}`);
    canvas.dataset.state = "rest";
    performance.mark("whole picture");
  } catch (error) {
    if (isCurrent()) say(error.message);
  }
}

function report(what) {
  figures.textContent = `${shown.name}: ${what}`;
}

function reportPicture(what) {
  report(`${shown.scene.stats.device.toUpperCase()}, ${what}`);
}

function say(what) {
  message.textContent = what;
}

/** Shows another file; if that fails, the picture stays. */
async function show(name, bytes) {
  say("");
  try {
    const scene = await load(await bytes, { gpu: asked.get("gpu") });
    shown?.scene.close();
    shown = { scene, orbit: new Orbit(scene), name };
    const { kind, name: title, background, isLinear } = scene.info;
    canvas.ariaLabel = `${title || name}, a radiance field (${kind}), seen from a camera that can be moved`;
    stage.style.background = `color(${isLinear ? "srgb-linear" : "srgb"} ${background.join(" ")})`;
    change();
  } catch (error) {
    say(`${name}: ${error.message}`);
  }
}

async function fetched(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

const perPixel = () => canvas.height / canvas.clientHeight;
watch(canvas, {
  turn(x, y) {
    shown?.orbit.drag(x, y, canvas.clientHeight);
    change();
  },
  shift(x, y) {
    const by = perPixel();
    shown?.orbit.pull(x * by, y * by, canvas.width, canvas.height);
    change();
  },
  approach(factor) {
    shown?.orbit.approach(factor);
    change();
  },
  async click(x, y) {
    if (!shown?.scene.info.hasDepth) return;
    const { scene, orbit } = shown;
    const by = perPixel();
    const camera = orbit.camera(canvas.width, canvas.height);
    let found;
    try {
      found = await scene.pick(x * by, y * by, camera);
    } catch (error) {
      if (scene === shown.scene) say(error.message);
      return;
    }
    if (scene !== shown.scene) return;
    const at = found?.point.map((v) => v.toFixed(2)).join(", ");
    report(found ? `${found.depth.toFixed(2)} away, at (${at})` : "nothing there");
  },
  reset,
});

function reset() {
  shown?.orbit.reset();
  change();
}

document.getElementById("reset").addEventListener("click", reset);
document.getElementById("file").addEventListener("change", ({ target }) => {
  if (target.files[0]) show(target.files[0].name, target.files[0].arrayBuffer());
  target.value = "";
});
addEventListener("dragover", (event) => {
  event.preventDefault();
  stage.classList.add("over");
});
addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) stage.classList.remove("over");
});
addEventListener("drop", (event) => {
  event.preventDefault();
  stage.classList.remove("over");
  const [file] = event.dataTransfer.files;
  if (file) show(file.name, file.arrayBuffer());
});

new ResizeObserver(() => {
  const { clientWidth, clientHeight } = canvas;
  if (!clientWidth || !clientHeight) return;
  const most = Math.sqrt(MOST_PIXELS / (clientWidth * clientHeight));
  const by = Math.min(devicePixelRatio, 2, most);
  const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(1, Math.round(side * by)));
  if (width === canvas.width && height === canvas.height) return;
  // Resizing clears a canvas: the old picture is shown until there is a new one.
  [small.width, small.height] = [canvas.width, canvas.height];
  small.getContext("2d").drawImage(canvas, 0, 0);
  [canvas.width, canvas.height] = [width, height];
  context.drawImage(small, 0, 0, width, height);
  change();
}).observe(canvas);

const model = asked.get("model") ?? "still-life.pnerf";
show(model.split("/").pop(), fetched(model));
