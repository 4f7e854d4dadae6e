// A radiance field among polygons of three.js: a ring turns before and behind it. Drag to look around.
//
//   embed-demo/web/build && python3 -m http.server -d embed-demo/web
//   then open http://localhost:8000/examples/three/

import * as THREE from "three";
import { load } from "pocketnerf";
import { Field } from "./field.js";

/** Pixels of the field's picture for each of the screen's, along a side. */
const DETAIL = 0.5;

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);
renderer.setClearColor(0xffffff);

// The dataset's coordinates are those of the scene: z is up.
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera();
const field = new Field();
const ring = new THREE.Mesh(new THREE.TorusGeometry(1, 0.12, 24, 96), new THREE.MeshNormalMaterial());
scene.add(ring, field.mesh);

const view = { azimuth: 0.6, elevation: 0.4 };
let model = null;
let hasChanged = true;
let isRendering = false;

try {
  model = await load(new URL("still-life.pnerf", import.meta.resolve("pocketnerf")));
  const { info } = model;
  ring.position.set(...info.center);
  ring.scale.setScalar(0.45 * info.size);
  addEventListener("resize", resize);
  addEventListener("pointermove", drag);
  resize();
  renderer.setAnimationLoop(frame);
} catch (error) {
  say(error.message);
}

function resize() {
  renderer.setSize(innerWidth, innerHeight);
  hasChanged = true;
}

function drag({ buttons, movementX, movementY }) {
  if (!buttons) return;
  view.azimuth -= (Math.PI * movementX) / innerHeight;
  view.elevation = Math.min(Math.max(view.elevation + (Math.PI * movementY) / innerHeight, -1.5), 1.5);
  hasChanged = true;
}

/** Polygons move at every frame; the field is rendered again when its camera has moved. */
function frame(milliseconds) {
  ring.rotation.set(milliseconds / 1500, milliseconds / 2300, 0);
  if (hasChanged && !isRendering) show();
  renderer.render(scene, camera);
}

async function show() {
  [hasChanged, isRendering] = [false, true];
  const [width, height] = [innerWidth, innerHeight].map((side) => Math.ceil(DETAIL * side));
  const seen = model.orbit(view.azimuth, view.elevation, { width, height });
  try {
    field.show(await model.layer(seen), seen);
    // Polygons follow when the picture is there: both are seen from one place.
    follow(seen);
  } catch (error) {
    say(error.message);
  }
  isRendering = false;
}

/** Takes over a camera of pocketnerf's: three's have the same axes. */
function follow({ pose, width, height, focal }) {
  camera.matrixAutoUpdate = false;
  camera.matrix.set(...pose);
  camera.updateMatrixWorld(true);
  camera.aspect = width / height;
  camera.fov = 2 * THREE.MathUtils.radToDeg(Math.atan((0.5 * height) / focal[1]));
  camera.near = 0.01 * model.info.size;
  camera.far = 100 * model.info.size;
  camera.updateProjectionMatrix();
}

function say(text) {
  document.getElementById("message").textContent = text;
}

export { camera, field, model, renderer, ring, scene };
