/**
 * Radiance fields in a web page, rendered on the GPU where the browser has one, or on the CPU.
 *
 * Coordinates and lengths are those of the photographs that a model was made from.
 */

/** A pinhole camera. Axes are OpenGL's: x right, y up, looking along -z. */
export interface Camera {
  /** Pixels, 1 to 16384. */
  width: number;
  height: number;
  /** Focal lengths in x and y, pixels. */
  focal: [number, number];
  /** Principal point, pixels from the top left corner; pixel (0, 0) has its centre at (0.5, 0.5). */
  center: [number, number];
  /** 4x4 camera-to-world, row after row: columns right, up, back (unit vectors), position. */
  pose: ArrayLike<number> & Iterable<number>;
}

/** Facts about a file. */
export interface Info {
  name: string;
  /** Kind of the field, such as `hash-grid`. */
  kind: string;
  method: string;
  program: string;
  dataset: string;
  /** The file's own view (`isOwn`), or one beside the scene; `tangent` is that of half its horizontal field of view. */
  camera: { pose: number[]; tangent: number; width: number; height: number; isOwn: boolean };
  /** The centre of the scene, and the longest side of the box around it; of a scene without an end, of the part that keeps its shape. */
  center: [number, number, number];
  size: number;
  /** The background, 0 to 1, in the model's own colour space. */
  background: [number, number, number];
  /** Colours and background are linear light; pictures are sRGB in any case. */
  isLinear: boolean;
  /** The default quality of pictures. */
  quality: number;
  /** Whether `pick` is supported: not for forward-facing captures and scenes without an end. */
  hasDepth: boolean;
  /** Distance between samples along a ray. */
  step: number;
  /** Occupied fraction of the box. */
  occupancy: number;
  /** The box in the model's own coordinates. */
  box: { min: number[]; max: number[] };
  /** From the model's coordinates: scale * rotation * model + translation; rotation row after row. */
  scene: { scale: number; rotation: number[]; translation: number[] };
  /** Forward-facing captures: distance of the nearest object; else 0. */
  near: number;
  /** What is up in the dataset's coordinates, a unit vector. */
  up: [number, number, number];
  /**
   * Where photographs were taken, poses as in `Camera`: an even choice of up to 64. Empty if the
   * file does not say it.
   */
  photographs: number[][];
}

export interface RenderOptions {
  /** From 0, the fastest, to 1, the finest; default `info.quality`. */
  quality?: number;
  /** Receives the size and the complete picture. */
  canvas?: HTMLCanvasElement | OffscreenCanvas;
  /** Called for each tile when it is rendered. */
  onTile?: (tile: ImageData, x: number, y: number) => void;
  /** Ends the picture: the promise rejects with the signal's reason, an `AbortError`. */
  signal?: AbortSignal;
}

export interface LayerOptions {
  /** From 0, the fastest, to 1, the finest; default `info.quality`. */
  quality?: number;
  signal?: AbortSignal;
}

/** What is composited with other things by depth. */
export interface Layer {
  width: number;
  height: number;
  /**
   * Red, green, blue and alpha in sRGB, without background, multiplied by alpha, from the top:
   * `pixels + (1 - alpha) * behind`; where `info.isLinear`, decode them first.
   */
  pixels: Uint8ClampedArray;
  /** The distance along each pixel's ray to what it sees on average, `Infinity` where that is nothing. */
  depth: Float32Array;
}

export interface OrbitOptions {
  /** From the centre of the scene; default: that of the file's own camera. */
  distance?: number;
  /** Default: z. */
  up?: [number, number, number];
  /** Default: the file's own size. */
  width?: number;
  height?: number;
}

export interface Pick {
  /** Distance from the camera to where half of the light is absorbed. */
  depth: number;
  point: [number, number, number];
}

export interface Stats {
  ms: number;
  rays: number;
  samples: number;
  /** Memory of the module, bytes. */
  memory: number;
  /**
   * What rendered the picture. A GPU renders from when its program is compiled, within seconds,
   * to when it fails. Its pictures differ in last bits from one to another.
   */
  device: "gpu" | "cpu";
}

export interface LoadOptions {
  /** `off`: render on the CPU. `software`: accept a software GPU too, for tests. */
  gpu?: "off" | "software";
  /** Ends the download and what else was begun: the promise rejects with the signal's reason. */
  signal?: AbortSignal;
  /** Called as a file is downloaded, with bytes; `total` is `null` where the server does not say. */
  onProgress?: (received: number, total: number | null) => void;
}

export declare class Scene {
  private constructor();
  readonly info: Info;
  /** Statistics of the last complete picture. */
  readonly stats: Stats;
  /** The file's own camera for a picture of this size, which shows all that its own picture shows. */
  camera(width?: number, height?: number): Camera;
  /**
   * A camera that looks at the centre of the scene: `azimuth` about the up axis from where x points
   * (from y if x is up), `elevation` above the horizon, radians.
   */
  orbit(azimuth: number, elevation: number, options?: OrbitOptions): Camera;
  /**
   * Renders a picture in a worker. Resolves to `null` if another picture was requested before
   * this one was complete: only the newest is rendered. Rejects with one line of text.
   */
  render(camera?: Camera, options?: RenderOptions): Promise<ImageData | null>;
  /** Renders colours without background, and depths; one of the pictures of which the newest counts. */
  layer(camera?: Camera, options?: LayerOptions): Promise<Layer | null>;
  /** What is at a point of the picture, pixels; default camera: that of the last picture. */
  pick(x: number, y: number, camera?: Camera): Promise<Pick | null>;
  /** Ends the worker. Pending calls reject. */
  close(): void;
}

/**
 * Opens a `.pnerf` file, with every byte checked; rejects with one line of text. Bytes are copied, a
 * response is read to its end.
 */
export declare function load(
  source: string | URL | Response | ArrayBuffer | ArrayBufferView | Blob,
  options?: LoadOptions,
): Promise<Scene>;
