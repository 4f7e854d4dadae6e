// A camera that turns around the scene and keeps its up direction: the same as
// embed-demo/native/src/view.rs, and a test compares the two. It is JavaScript because the
// module belongs to the worker, and every event of the mouse would wait for an answer from it.

/** Largest angle above or below the horizon, radians. */
const STEEPEST = 1.55;
const NEAREST = 1 / 64;
const FARTHEST = 16;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const add = (a, b, scale = 1) => a.map((v, i) => v + scale * b[i]);
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
const column = (pose, c) => [pose[c], pose[4 + c], pose[8 + c]];

/** `v` turned about the unit vector `axis`. */
function turned(v, axis, angle) {
  const [cos, sin, along] = [Math.cos(angle), Math.sin(angle), dot(v, axis)];
  const aside = [
    axis[1] * v[2] - axis[2] * v[1],
    axis[2] * v[0] - axis[0] * v[2],
    axis[0] * v[1] - axis[1] * v[0],
  ];
  return v.map((x, i) => x * cos + aside[i] * sin + axis[i] * along * (1 - cos));
}

/**
 * Starts at a camera and keeps the turns since, so rounding errors do not add up: the scene's own
 * one, or one that it went to.
 */
export class Orbit {
  #scene;
  #pose;
  #fov;
  #axes;
  #target;
  #up;
  #far;

  constructor(scene) {
    this.#scene = scene;
    this.reset();
  }

  reset() {
    this.goTo(this.#scene.info.camera.pose);
  }

  /** Goes to a pose, with a vertical field of view in degrees or the scene's own. */
  goTo(pose, fov = null) {
    const { info } = this.#scene;
    [this.#pose, this.#fov] = [pose, fov];
    const [right, up, back, eye] = [0, 1, 2, 3].map((c) => column(pose, c));
    this.#axes = [right, up, back];
    const isAround = info.near === 0;
    const along = isAround ? -dot(add(info.center, eye, -1), back) : 4 * info.near;
    // A camera that looks away from the scene turns around a point in front of it.
    this.#far = Math.max(along, 0.1 * info.size);
    this.#target = add(eye, back, -this.#far);
    // Up in the scene, or, if the camera lies on its side, in its picture.
    this.#up = isAround && dot(up, info.up) > 0.5 ? info.up : up;
    [this.yaw, this.rise, this.distance, this.pan] = [0, 0, 1, [0, 0, 0]];
  }

  /** Turns by a drag in pixels of a picture of this height. */
  drag(x, y, height) {
    this.turn((-x * Math.PI) / height, (y * Math.PI) / height);
  }

  /** Turns by radians to the right and up. */
  turn(right, up) {
    const begun = Math.asin(clamp(dot(this.#axes[2], this.#up), -1, 1));
    const [low, high] = [-Math.max(STEEPEST, -begun) - begun, Math.max(STEEPEST, begun) - begun];
    this.yaw = (this.yaw + right) % (2 * Math.PI);
    this.rise = clamp(this.rise + up, low, high);
  }

  /** Moves sideways: the target stays under the hand. */
  pull(x, y, width, height) {
    const [focal] = this.camera(width, height).focal;
    const [right, up] = this.#turnedAxes();
    const length = (this.#far * this.distance) / focal;
    this.pan = add(add(this.pan, right, -x * length), up, y * length);
  }

  /** Multiplies the distance by `factor`. */
  approach(factor) {
    this.distance = clamp(this.distance * factor, NEAREST, FARTHEST);
  }

  /** The camera for a picture of this size. */
  camera(width, height) {
    const camera = { ...this.#scene.camera(width, height), pose: [...this.#pose] };
    if (this.#fov) camera.focal.fill((0.5 * height) / Math.tan((this.#fov * Math.PI) / 360));
    const isUntouched = !this.yaw && !this.rise && this.distance === 1 && !this.pan.some(Boolean);
    if (isUntouched) return camera;
    const [right, up, back] = this.#turnedAxes();
    const eye = add(add(this.#target, this.pan), back, this.#far * this.distance);
    const rows = [0, 1, 2].flatMap((i) => [right[i], up[i], back[i], eye[i]]);
    return { ...camera, pose: [...rows, 0, 0, 0, 1] };
  }

  #turnedAxes() {
    const [right] = this.#axes;
    return this.#axes.map((v) => turned(turned(v, right, -this.rise), this.#up, this.yaw));
  }
}
