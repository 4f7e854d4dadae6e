// Cameras of a file, for a picture of any size.

/** The file's own camera, or one beside the scene. */
export function own(info, width, height) {
  const { pose, tangent, width: ownWidth, height: ownHeight } = info.camera;
  // In 32 bits, like the renderer, so pictures are the same to the byte.
  let focal = Math.fround(Math.fround(0.5 * width) / tangent);
  // This picture shows all that the file's own shows.
  const wide = (width * ownHeight) / (height * ownWidth);
  if (wide > 1) focal = Math.fround(focal / wide);
  return {
    width,
    height,
    focal: [focal, focal],
    center: [0.5 * width, 0.5 * height],
    pose: [...pose],
  };
}

/** The same, placed by two angles around the centre of the scene. */
export function orbit(info, azimuth, elevation, { distance, up, width, height }) {
  const camera = own(info, width, height);
  const axis = unit(up);
  const start = Math.abs(axis[0]) < 0.999 ? [1, 0, 0] : [0, 1, 0];
  const first = unit(start.map((v, a) => v - dot(start, axis) * axis[a]));
  const second = cross(axis, first);
  const [reach, rise] = [Math.cos(elevation), Math.sin(elevation)];
  const back = axis.map((v, a) => {
    return rise * v + reach * (Math.cos(azimuth) * first[a] + Math.sin(azimuth) * second[a]);
  });
  const eye = [3, 7, 11].map((i) => camera.pose[i]);
  const far = distance ?? Math.hypot(...eye.map((v, a) => v - info.center[a]));
  const right = unit(cross(axis, back));
  const above = cross(back, right);
  const rows = [0, 1, 2].flatMap((a) => [right[a], above[a], back[a], info.center[a] + far * back[a]]);
  return { ...camera, pose: [...rows, 0, 0, 0, 1] };
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (v) => v.map((x) => x / Math.hypot(...v));
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
