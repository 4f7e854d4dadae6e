// The page: a small picture while something moves, the complete one at rest.

import { CameraPath } from "./camera-path.js";
import { watch } from "./gestures.js";
import { normals } from "./normals.js";
import { Orbit } from "./orbit.js";
import { Pace } from "./pace.js";
import { load } from "./pocketnerf.js";

/** Target rate of moving pictures per second. */
const FPS = 30;
/** Milliseconds of rest after which the complete picture starts. */
const SETTLES = 60;
/** The most pixels of a picture, however fine the screen is. */
const MOST_PIXELS = 1.5e6;

const byId = (id) => document.getElementById(id);
const [canvas, stage, message, figures] = ["picture", "stage", "message", "figures"].map(byId);
const context = canvas.getContext("2d", { alpha: false });
const small = document.createElement("canvas");
const pace = new Pace(FPS);
const asked = new URLSearchParams(location.search);

/** The scene that is shown, its view, its keyframes, its photograph, and the name of its file. */
let shown = null;
/** The path that is played: its pictures, when it began, and what it waits for. */
let playing = null;
let showsNormals = false;
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
  const image = await picture(scene, scaled(orbit.camera(width, height), w, h), { quality: 0 });
  if (!image || scene !== shown.scene) return;
  const ms = performance.now() - begun;
  pace.rendered(w * h, width * height, ms);
  [small.width, small.height] = [w, h];
  small.getContext("2d").putImageData(image, 0, 0);
  context.drawImage(small, 0, 0, canvas.width, canvas.height);
  reportPicture(`${ms.toFixed(0)} ms a frame at ${w} × ${h}, detail ${Math.round(100 * pace.scale)} %`);
}

/** What a camera sees, or the normals of that. */
async function picture(scene, camera, options) {
  if (!showsNormals) return scene.render(camera, options);
  const layer = await scene.layer(camera, options);
  return layer && normals(layer, camera, scene.info);
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
    const image = await picture(scene, orbit.camera(width, height), { onTile });
    if (!image || !isCurrent()) return;
    context.putImageData(image, 0, 0);
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
  const parts = [shown.note, `${shown.scene.stats.device.toUpperCase()}, ${what}`];
  report(parts.filter(Boolean).join(" · "));
}

/** What figures of pictures do not cover, until the next input. */
function note(what) {
  shown.note = what;
  report(what);
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
    stop();
    shown = { scene, orbit: new Orbit(scene), path: new CameraPath(), photograph: null, note: "", name };
    byId("photographs").hidden = !scene.info.photographs.length;
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

/** Shows the picture of the path whose time has come, frame by frame of the screen. */
function tick() {
  const { pictures, fps, begun } = playing;
  const due = Math.floor(((performance.now() - begun) * fps) / 1000);
  const { pose, fov } = pictures[Math.min(due, pictures.length - 1)];
  shown.orbit.goTo(pose, fov);
  change();
  playing.frame = requestAnimationFrame(tick);
  if (due + 1 >= pictures.length) stop();
}

function stop() {
  if (playing) cancelAnimationFrame(playing.frame);
  playing = null;
  byId("play").ariaPressed = false;
}

/** Goes to the photograph that many after the one that was shown last. */
function goToPhotograph(by) {
  const all = shown.scene.info.photographs;
  if (!all.length) return;
  shown.photograph = ((shown.photograph ?? (by > 0 ? -1 : 0)) + by + all.length) % all.length;
  shown.orbit.goTo(all[shown.photograph]);
  change();
  note(`photograph ${shown.photograph + 1} of ${all.length}`);
}

function download(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = name;
  link.click();
  // Not before the browser has it.
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** What buttons of these names do. */
const actions = {
  reset,
  normals() {
    showsNormals = !showsNormals;
    byId("normals").ariaPressed = showsNormals;
    change();
  },
  previous: () => goToPhotograph(-1),
  next: () => goToPhotograph(1),
  add() {
    shown.path.add(shown.orbit.camera(canvas.width, canvas.height));
    note(shown.path.words);
  },
  remove() {
    shown.path.keyframes.pop();
    note(shown.path.words);
  },
  play() {
    if (playing) return stop();
    const { path } = shown;
    if (path.keyframes.length < 2) return note("a path takes two keyframes");
    playing = { pictures: path.pictures, fps: path.fps, begun: performance.now() };
    byId("play").ariaPressed = true;
    tick();
  },
  save() {
    const { path } = shown;
    if (!path.keyframes.length) return note("no keyframes to save");
    download("camera_path.json", path.text([canvas.width, canvas.height]));
    note(`camera_path.json: saved, ${path.words}`);
  },
};
const keys = { n: "normals", ",": "previous", ".": "next", k: "add", Backspace: "remove", p: "play", w: "save" };
const act = (name) => shown && actions[name]();

for (const name of Object.keys(actions)) byId(name).addEventListener("click", () => act(name));
addEventListener("keydown", (event) => {
  const name = keys[event.key];
  if (!name || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  act(name);
});
// Any input ends a path; what plays it does so itself.
for (const kind of ["pointerdown", "wheel", "keydown"]) {
  const begin = ({ key, target }) => {
    if (shown) shown.note = "";
    if (key !== "p" && target.id !== "play") stop();
  };
  addEventListener(kind, begin, { capture: true });
}

/** Opens a model, or the keyframes of a path. */
function open(file) {
  if (file.name.endsWith(".json")) openPath(file);
  else show(file.name, file.arrayBuffer());
}

async function openPath(file) {
  say("");
  try {
    const text = await file.text();
    if (!shown) throw new Error("a camera path needs a model; open one first");
    shown.path = CameraPath.of(text);
    const [{ pose, fov }] = shown.path.keyframes;
    shown.orbit.goTo(pose, fov);
    change();
    note(`${file.name}, ${shown.path.words}`);
  } catch (error) {
    say(`${file.name}: ${error.message}`);
  }
}

byId("file").addEventListener("change", ({ target }) => {
  if (target.files[0]) open(target.files[0]);
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
  if (file) open(file);
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
