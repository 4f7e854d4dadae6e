// Normals, from the distances that a picture has: the field is not asked for its gradient, as the
// window does.

/** Neighbours to each side that a normal is made of. */
const REACH = 2;
/** Between neighbours that only a steeper surface would join (tangent of the angle) is an edge. */
const STEEPEST = 8;

/**
 * Pixels of the surfaces' normals: x, y and z of the dataset's coordinates as red, green and blue.
 * Along a plane, the inverse of the depth is linear in the picture's coordinates. The normal is
 * that of the plane which fits the neighbours' best, without those across an edge; where there is
 * none, it faces the camera.
 */
export function normals({ width, height, pixels, depth }, { focal, center, pose }, info) {
  const image = new ImageData(width, height);
  const behind = info.background.map((v) => 255 * (info.isLinear ? encoded(v) : v));
  const across = (x) => (x + 0.5 - center[0]) / focal[0];
  const upward = (y) => (center[1] - y - 0.5) / focal[1];
  // Along the camera's axis; 0 where there is nothing.
  const inverse = depth.map((t, i) => {
    return Math.hypot(1, across(i % width), upward(Math.floor(i / width))) / t;
  });
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const i = y * width + x;
      const alpha = pixels[4 * i + 3] / 255;
      const slope = alpha > 0 && fitted(inverse, width, height, x, y, STEEPEST / focal[0]);
      const [sx, sy] = slope ? [slope[0] * focal[0], -slope[1] * focal[1]] : [0, 0];
      const n = [-sx, -sy, inverse[i] - sx * across(x) - sy * upward(y)];
      const length = Math.hypot(...n);
      for (let a = 0; a < 3; a += 1) {
        const along = n[0] * pose[4 * a] + n[1] * pose[4 * a + 1] + n[2] * pose[4 * a + 2];
        const color = length > 0 ? 127.5 * (1 + along / length) : behind[a];
        image.data[4 * i + a] = alpha * color + (1 - alpha) * behind[a];
      }
      image.data[4 * i + 3] = 255;
    }
  }
  return image;
}

/** How `values` change from a pixel to the next, by least squares; null where none is known. */
function fitted(values, width, height, x, y, steepest) {
  const own = values[y * width + x];
  let [xx, xy, yy, xv, yv] = [0, 0, 0, 0, 0];
  for (let v = Math.max(-REACH, -y); v <= Math.min(REACH, height - 1 - y); v += 1) {
    for (let u = Math.max(-REACH, -x); u <= Math.min(REACH, width - 1 - x); u += 1) {
      const change = values[(y + v) * width + x + u] - own;
      if (Math.abs(change) > steepest * own * Math.max(Math.abs(u), Math.abs(v))) continue;
      xx += u * u;
      xy += u * v;
      yy += v * v;
      xv += u * change;
      yv += v * change;
    }
  }
  const determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return null;
  return [(yy * xv - xy * yv) / determinant, (xx * yv - xy * xv) / determinant];
}

/** Linear light as sRGB. */
const encoded = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
