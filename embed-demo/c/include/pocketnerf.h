/* pocketnerf: radiance fields from .pnerf files, on the CPU.
 *
 * Made by cbindgen from embed-demo/c/src: do not edit.
 *
 * A function that can fail returns a PnrfStatus. Given a PnrfError, it also fills in one line about
 * what was found and what was expected; outputs are then unchanged. The library has no global state,
 * starts no threads and prints nothing. An open model never changes, so any number of threads may use
 * it; each thread needs its own scratch.
 *
 * Coordinates, lengths and densities are those of the photographs that a model was made from, unless
 * it was opened with PNRF_OPEN_MODEL_COORDINATES. Memory that a call writes to must not overlap any
 * other memory passed to it.
 */

#ifndef POCKETNERF_H
#define POCKETNERF_H

#include <stddef.h>
#include <stdint.h>

// The version of this interface: 65536 times the major number, plus the minor. Additions
// increase the minor number, all other changes the major one.
#define PNRF_ABI_VERSION 65538

// The largest width and height of a picture, pixels.
#define PNRF_MAX_SIDE 16384

// For `pnrf_open_bytes`: the bytes are not copied. They must stay in place, unchanged, until
// the model is closed. (A packed file is unpacked to memory of the model's own.)
#define PNRF_OPEN_BORROWED 1

// Skip the check of checksums and weights: opening takes no time, whatever the size. Damaged
// weights then give wrong pictures, but never a crash.
#define PNRF_OPEN_UNVERIFIED 2

// Do not build the empty-space skip table: less memory (`table_bytes` of `PnrfInfo`), the
// same pictures, 10 to 15 % more time.
#define PNRF_OPEN_WITHOUT_TABLE 4

// Use the model's own coordinates and units for cameras, points and lengths, instead of
// those of the photographs it was made from.
#define PNRF_OPEN_MODEL_COORDINATES 8

// Size of an error's text in bytes, with the final zero.
#define PNRF_ERROR_TEXT 252

// The outcome of a call.
enum PnrfStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Success.
    PNRF_STATUS_OK = 0,
    // A pointer that must not be null is null.
    PNRF_STATUS_NULL = 1,
    // A pointer is not aligned for its type. (Pixels, depths and the bytes of a model need no
    // alignment.)
    PNRF_STATUS_MISALIGNED = 2,
    // A number is out of range, NaN, or an unknown code.
    PNRF_STATUS_ARGUMENT = 3,
    // The camera has no pixels, has numbers that are not finite, or a pose that is not a
    // rotation.
    PNRF_STATUS_CAMERA = 4,
    // A buffer is too small.
    PNRF_STATUS_BUFFER = 5,
    // The file cannot be read.
    PNRF_STATUS_FILE = 6,
    // The bytes are not a .pnerf model.
    PNRF_STATUS_NOT_A_MODEL = 7,
    // The model has a format version, or parts, that this library does not support.
    PNRF_STATUS_VERSION = 8,
    // The bytes of the model are damaged.
    PNRF_STATUS_DAMAGED = 9,
    // The model does not support this query.
    PNRF_STATUS_UNSUPPORTED = 10,
    // The machine lacks these vector instructions.
    PNRF_STATUS_NO_SIMD = 11,
    // A bug in the library.
    PNRF_STATUS_INTERNAL = 12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfStatus PnrfStatus;
#else
typedef int32_t PnrfStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How transparency is stored.
enum PnrfAlpha
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Pixels are composited over the image's background; alpha is 1.
    PNRF_ALPHA_BACKGROUND = 0,
    // Colours are multiplied by alpha, without background: out = this + (1 - alpha) * behind.
    // Bytes of a linear model are to be decoded first, as sRGB textures do.
    PNRF_ALPHA_PREMULTIPLIED = 1,
    // Colours are not multiplied by alpha, as in PNG files.
    PNRF_ALPHA_STRAIGHT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfAlpha PnrfAlpha;
#else
typedef uint32_t PnrfAlpha;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Definition of the depth along a ray.
enum PnrfDepth
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The expected depth, as in a rendered picture.
    PNRF_DEPTH_EXPECTED = 0,
    // Where half of the light is absorbed.
    PNRF_DEPTH_MEDIAN = 1,
    // The first sample whose sigma exceeds the threshold, 1 / unit; finds transparent objects
    // too (Dex-NeRF).
    PNRF_DEPTH_FIRST_SIGMA = 2,
    // Where the fraction `threshold` of the light, from 1e-6 to below 1, is absorbed.
    PNRF_DEPTH_FIRST_OPACITY = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfDepth PnrfDepth;
#else
typedef uint32_t PnrfDepth;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The kind of distance that a depth is.
enum PnrfDepthKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // From the camera's position, along the ray.
    PNRF_DEPTH_KIND_DISTANCE = 0,
    // From the plane through the camera, along its viewing direction, as for a z-buffer.
    PNRF_DEPTH_KIND_Z = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfDepthKind PnrfDepthKind;
#else
typedef uint32_t PnrfDepthKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The format of a pixel. Bytes are sRGB; `float` values are in the model's own colour space,
// see `is_linear` of `PnrfInfo`.
enum PnrfFormat
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Four bytes: red, green, blue, alpha.
    PNRF_FORMAT_RGBA8 = 0,
    // Four bytes: blue, green, red, alpha, as in many window systems.
    PNRF_FORMAT_BGRA8 = 1,
    // Four `float` values: red, green, blue, alpha.
    PNRF_FORMAT_RGBA_F32 = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfFormat PnrfFormat;
#else
typedef uint32_t PnrfFormat;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How much scratch memory a call uses.
enum PnrfMemory
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Up to 1.2 MB for a hash grid: the size of a core's L2 cache.
    PNRF_MEMORY_FAST = 0,
    // A few tens of kilobytes; slower. Tiles are smaller, so pictures differ slightly, within
    // the tolerance of the quality.
    PNRF_MEMORY_SMALL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfMemory PnrfMemory;
#else
typedef uint32_t PnrfMemory;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where the samples of a ray lie.
enum PnrfSampling
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // At equal steps through occupied cells, until almost no light passes.
    PNRF_SAMPLING_OCCUPANCY = 0,
    // Hierarchical sampling of vanilla NeRF, coarse then fine; ignores quality. Much slower.
    PNRF_SAMPLING_HIERARCHICAL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfSampling PnrfSampling;
#else
typedef uint32_t PnrfSampling;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Vector instructions. Those that the machine lacks are an error.
enum PnrfSimd
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The best available.
    PNRF_SIMD_DETECT = 0,
    // The baseline of the build target.
    PNRF_SIMD_PORTABLE = 1,
    // x86-64-v2: 4 lanes.
    PNRF_SIMD_SSE42 = 2,
    // x86-64-v3: 8 lanes.
    PNRF_SIMD_AVX2 = 3,
    // Ice Lake, Zen 4 and later: 16 lanes.
    PNRF_SIMD_AVX512 = 4,
    // AArch64: 4 lanes.
    PNRF_SIMD_NEON = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfSimd PnrfSimd;
#else
typedef uint32_t PnrfSimd;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Facts about a model, in words.
enum PnrfText
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The name of the scene.
    PNRF_TEXT_NAME = 0,
    // The kind of its field, such as `hash-grid`.
    PNRF_TEXT_KIND = 1,
    // The method of its training, or what it was converted from.
    PNRF_TEXT_METHOD = 2,
    // The program that wrote it, with its version.
    PNRF_TEXT_PROGRAM = 3,
    // The name of the dataset that it was trained on.
    PNRF_TEXT_DATASET = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfText PnrfText;
#else
typedef uint32_t PnrfText;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// An open model. It never changes, so any number of threads may use it at the same time.
typedef struct PnrfModel PnrfModel;

// A pinhole camera. Axes are OpenGL's: x right, y up, looking along -z. The centre of the
// upper left pixel is at (0.5, 0.5).
typedef struct PnrfCamera {
    // Picture width in pixels, 1 to `PNRF_MAX_SIDE`.
    uint32_t width;
    // Picture height in pixels, 1 to `PNRF_MAX_SIDE`.
    uint32_t height;
    // Focal lengths in x and y, pixels, above 0.
    float focal[2];
    // Principal point in x and y, pixels from the top left corner. To render a part of a
    // picture, move it and make the picture smaller.
    float center[2];
    // 4x4 camera-to-world matrix, row after row: columns are right, up, back (unit
    // vectors) and the camera's position. The last row is ignored.
    float camera_to_world[16];
} PnrfCamera;

// A status with a line about what was found and what was expected. A call that can fail fills
// it in, unless the pointer is null.
typedef struct PnrfError {
    // The status that the call returns.
    PnrfStatus status;
    // One line of UTF-8 with a final zero; empty after success.
    char text[PNRF_ERROR_TEXT];
} PnrfError;

// Facts about a model, in numbers. The box of contracted space, which has no end, is the cube
// that keeps its shape.
typedef struct PnrfInfo {
    // Length of the file.
    uint64_t bytes;
    // Number of weights.
    uint64_t parameters;
    // Size of the empty-space skip table, which an open model needs beside its bytes.
    uint64_t table_bytes;
    // Occupied fraction of the model's box; 1 if unknown.
    float occupancy;
    // The centre of its box, caller's coordinates.
    float center[3];
    // The radius of the sphere around the box, caller's units.
    float radius;
    // Smallest corner of the box, model's coordinates.
    float box_min[3];
    // Largest corner of the box, model's coordinates.
    float box_max[3];
    // Caller's units per unit of the model: caller = scale * rotation * model +
    // translation.
    float scale;
    // The `rotation` above, row after row.
    float rotation[9];
    // The `translation` above.
    float translation[3];
    // Distance between samples along a ray, caller's units.
    float step;
    // The model's background, 0 to 1, in its own colour space.
    float background[3];
    // 1: colours and background are linear light, and only pictures in bytes are encoded as
    // sRGB; 0: all colours are sRGB, as in image files.
    uint32_t is_linear;
    // 1: queries about points, segments and rays are supported; 0: the model is in normalised
    // device coordinates or in contracted space, for pictures only.
    uint32_t has_queries;
    // 1: the file has its own view; see `pnrf_default_camera`.
    uint32_t has_camera;
    // The default quality of pictures.
    float quality;
} PnrfInfo;

// Options of rendering and of queries. `pnrf_default_options` fills in the defaults, which
// a null pointer stands for too.
typedef struct PnrfOptions {
    // A `PnrfSimd`.
    uint32_t simd;
    // A `PnrfSampling`.
    uint32_t sampling;
    // A `PnrfMemory`.
    uint32_t memory;
    // From 0, the fastest, to 1, the finest; below 0: as the file says, usually 0.5.
    float quality;
} PnrfOptions;

// What a ray meets.
typedef struct PnrfHit {
    // Distance from the camera to where half of the light is absorbed, the caller's units;
    // infinite where less is.
    float depth;
    // That point, caller's coordinates; zero where nothing is hit.
    float point[3];
    // Where the surface faces, a unit vector; zero where nothing is hit. The mean of the normals
    // at four points around, which is smoother than that of `pnrf_normals`.
    float normal[3];
} PnrfHit;

// A whole picture in the caller's memory, at any alignment, rows from top to bottom. Only the
// pixels of rendered tiles are written. Set the struct to zero first: the default is RGBA in
// bytes over black, without depth or padding.
typedef struct PnrfImage {
    // The upper left pixel, or null for depth alone.
    void *pixels;
    // Size of `pixels` in bytes.
    size_t size;
    // Bytes from one row to the next; 0: rows without padding.
    size_t stride;
    // A `PnrfFormat`.
    uint32_t format;
    // A `PnrfAlpha`.
    uint32_t alpha;
    // Red, green and blue, 0 to 1, for `PNRF_ALPHA_BACKGROUND`: in the model's own colour
    // space, as in `PnrfInfo`.
    float background[3];
    // 1: rows from bottom to top, as in OpenGL textures; for depth too.
    uint32_t bottom_up;
    // One `float` per pixel: the expected distance in the caller's units, infinite where
    // there is nothing. Null for none.
    float *depth;
    // Size of `depth` in bytes.
    size_t depth_size;
    // Bytes from one row to the next; 0: rows without padding.
    size_t depth_stride;
    // A `PnrfDepthKind`.
    uint32_t depth_kind;
} PnrfImage;

// Statistics of rendering, to be summed over tiles.
typedef struct PnrfStats {
    // Rays cast; the other pixels are interpolated, or known to be empty.
    uint64_t rays;
    // Evaluations of the field.
    uint64_t samples;
    // Rays with at least one evaluation.
    uint64_t hits;
} PnrfStats;

// A rectangle of pixels.
typedef struct PnrfTile {
    // Leftmost column.
    uint32_t x;
    // Topmost row.
    uint32_t y;
    // Columns.
    uint32_t width;
    // Rows.
    uint32_t height;
} PnrfTile;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the library. It fits the header if the upper 16 bits equal those of
// `PNRF_ABI_VERSION`, and the lower ones are not smaller.
uint32_t pnrf_abi_version(void);

// Makes a camera at `eye` that looks at `target`, three numbers each. `up` is the
// approximate up direction, of any length; `fov_x` is the horizontal field of view in
// radians, 0.01 to 3.1.
PnrfStatus pnrf_look_at(const float *eye,
                        const float *target,
                        const float *up,
                        float fov_x,
                        uint32_t width,
                        uint32_t height,
                        struct PnrfCamera *camera,
                        struct PnrfError *error);

// Writes facts about a model, in numbers, to `info`.
PnrfStatus pnrf_info(const struct PnrfModel *model, struct PnrfInfo *info, struct PnrfError *error);

// Copies a text in UTF-8 with a final zero to `buffer`; empty if the file has none. `which`
// is a `PnrfText`; `capacity` is the size of `buffer` in bytes, and too small a buffer is an
// error. `length`, unless null, receives the bytes needed, with the zero, even then.
PnrfStatus pnrf_text(const struct PnrfModel *model,
                     uint32_t which,
                     char *buffer,
                     size_t capacity,
                     size_t *length,
                     struct PnrfError *error);

// Opens a file. All of it is read, so it may change or be deleted afterwards.
//
// `path` is UTF-8 on Windows, any bytes elsewhere. `flags` are `PNRF_OPEN_…`, or 0. `model`
// receives the model, to be closed with `pnrf_close`, or null if the call fails.
PnrfStatus pnrf_open_file(const char *path,
                          uint32_t flags,
                          struct PnrfModel **model,
                          struct PnrfError *error);

// Opens a model in memory: `length` bytes, at any alignment. They are copied, unless `flags`
// has `PNRF_OPEN_BORROWED`.
//
// `flags` are `PNRF_OPEN_…`, or 0. `model` receives the model, to be closed with `pnrf_close`,
// or null if the call fails.
PnrfStatus pnrf_open_bytes(const void *bytes,
                           size_t length,
                           uint32_t flags,
                           struct PnrfModel **model,
                           struct PnrfError *error);

// Closes a model that is no longer in use. Null is ignored.
void pnrf_close(struct PnrfModel *model);

// Writes the default options to `options`.
PnrfStatus pnrf_default_options(struct PnrfOptions *options, struct PnrfError *error);

// Writes to `length` the number of `float` values of scratch that a call needs, for any
// picture and any query of this model. Each thread needs its own. Its content does not matter
// before a call, and is undefined afterwards.
PnrfStatus pnrf_scratch_length(const struct PnrfModel *model,
                               const struct PnrfOptions *options,
                               size_t *length,
                               struct PnrfError *error);

// Finds what is under `n` pixels of a camera's picture, x and y in two numbers each, from the top
// left corner: the centre of the first pixel is at (0.5, 0.5). One hit each to `hits`.
PnrfStatus pnrf_pick(const struct PnrfModel *model,
                     const struct PnrfOptions *options,
                     const struct PnrfCamera *camera,
                     const float *pixels,
                     size_t n,
                     struct PnrfHit *hits,
                     float *scratch,
                     size_t scratch_length,
                     struct PnrfError *error);

// Sigma at `n` points, three numbers each: one value each to `sigma`, the fraction of light
// absorbed per unit of length, 1 / unit; 0 in empty space.
PnrfStatus pnrf_density(const struct PnrfModel *model,
                        const struct PnrfOptions *options,
                        const float *points,
                        size_t n,
                        float *sigma,
                        float *scratch,
                        size_t scratch_length,
                        struct PnrfError *error);

// Colour and sigma at `n` points, three numbers each, seen along `directions`, three numbers
// each: four values each to `rgb_sigma`. Red, green and blue are 0 to 1, not premultiplied, in
// the model's own colour space; sigma is in 1 / unit. All are 0 in empty space.
PnrfStatus pnrf_radiance(const struct PnrfModel *model,
                         const struct PnrfOptions *options,
                         const float *points,
                         const float *directions,
                         size_t n,
                         float *rgb_sigma,
                         float *scratch,
                         size_t scratch_length,
                         struct PnrfError *error);

// The gradient of sigma at `n` points, three numbers each: three values each to `gradient`,
// 1 / unit^2.
PnrfStatus pnrf_density_gradient(const struct PnrfModel *model,
                                 const struct PnrfOptions *options,
                                 const float *points,
                                 size_t n,
                                 float *gradient,
                                 float *scratch,
                                 size_t scratch_length,
                                 struct PnrfError *error);

// Surface normals at `n` points, three numbers each: a unit vector each to `normals`, three
// numbers; zero where sigma has no gradient.
PnrfStatus pnrf_normals(const struct PnrfModel *model,
                        const struct PnrfOptions *options,
                        const float *points,
                        size_t n,
                        float *normals,
                        float *scratch,
                        size_t scratch_length,
                        struct PnrfError *error);

// Whether `n` points, three numbers each, lie in occupied cells: one byte each to `occupied`,
// 0 or 1. NaN counts as occupied.
PnrfStatus pnrf_occupied(const struct PnrfModel *model,
                         const float *points,
                         size_t n,
                         uint8_t *occupied,
                         struct PnrfError *error);

// Whether `n` spheres, centre and radius in four numbers each, are free: one byte each to
// `clear`, 1 if no occupied cell touches the sphere, else 0. The answer is conservative: it
// is never wrongly 1. NaN is not clear.
PnrfStatus pnrf_sphere_clear(const struct PnrfModel *model,
                             const float *balls,
                             size_t n,
                             uint8_t *clear,
                             struct PnrfError *error);

// Transmittance of `n` segments, two points in six numbers each: one value each to `passes`,
// 1 if nothing is in the way.
PnrfStatus pnrf_segment_transmittance(const struct PnrfModel *model,
                                      const struct PnrfOptions *options,
                                      const float *segments,
                                      size_t n,
                                      float *passes,
                                      float *scratch,
                                      size_t scratch_length,
                                      struct PnrfError *error);

// The probability that a body collides (CATNIPS): 1 - exp(-sum of sigma * volume /
// particle_area) over the `n` points that fill it, three numbers each. Each point stands for
// `volume`, unit^3; `particle_area`, unit^2, is the cross-section of the smallest relevant
// obstacle.
PnrfStatus pnrf_collision_probability(const struct PnrfModel *model,
                                      const struct PnrfOptions *options,
                                      const float *points,
                                      size_t n,
                                      float volume,
                                      float particle_area,
                                      float *probability,
                                      float *scratch,
                                      size_t scratch_length,
                                      struct PnrfError *error);

// Depths along `n` rays, origin and direction in six numbers each: one value each to `depths`,
// units; infinite if there is none.
//
// `kind` is a `PnrfDepth`, with its `threshold`. `axis`, three numbers, gives depths along that
// direction, such as a camera's, instead of along the ray; null: along the ray.
PnrfStatus pnrf_depths(const struct PnrfModel *model,
                       const struct PnrfOptions *options,
                       const float *rays,
                       size_t n,
                       uint32_t kind,
                       float threshold,
                       const float *axis,
                       float *depths,
                       float *scratch,
                       size_t scratch_length,
                       struct PnrfError *error);

// Renders a picture on the calling thread.
//
// `image` holds all of the camera's picture. `scratch` has `scratch_length` values, at least
// those of `pnrf_scratch_length`. `stats` may be null. If the call fails, only `error` is
// written.
PnrfStatus pnrf_render(const struct PnrfModel *model,
                       const struct PnrfCamera *camera,
                       const struct PnrfOptions *options,
                       const struct PnrfImage *image,
                       float *scratch,
                       size_t scratch_length,
                       struct PnrfStats *stats,
                       struct PnrfError *error);

// Renders one tile of a picture, `number` from 0 to `pnrf_tile_count` - 1, into its place in
// the image of the whole picture. Otherwise the same as `pnrf_render`, which renders one tile
// after another. Several threads may render tiles of one image at the same time, each with its
// own scratch.
PnrfStatus pnrf_render_tile(const struct PnrfModel *model,
                            const struct PnrfCamera *camera,
                            const struct PnrfOptions *options,
                            uint32_t number,
                            const struct PnrfImage *image,
                            float *scratch,
                            size_t scratch_length,
                            struct PnrfStats *stats,
                            struct PnrfError *error);

// The number of tiles of a picture of this size; 0 if the size or the options are invalid.
// `options` as for rendering.
uint32_t pnrf_tile_count(uint32_t width, uint32_t height, const struct PnrfOptions *options);

// Writes the rectangle that a tile covers to `tile`, to show tiles as they are rendered.
PnrfStatus pnrf_tile(uint32_t width,
                     uint32_t height,
                     const struct PnrfOptions *options,
                     uint32_t number,
                     struct PnrfTile *tile,
                     struct PnrfError *error);

// A short description of any status code. The text is valid for ever.
const char *pnrf_status_text(int32_t status);

// Makes a camera that shows the model: the file's own view, or, if it has none, one from
// the side and above. A width and height of 0 mean the file's own size.
PnrfStatus pnrf_default_camera(const struct PnrfModel *model,
                               uint32_t width,
                               uint32_t height,
                               struct PnrfCamera *camera,
                               struct PnrfError *error);

// Makes a camera that goes around the centre of the model and looks at it, with the field of view
// of the default camera.
//
// `azimuth` is the angle about `up`, radians, counter-clockwise seen from above; 0 is where the x
// axis points, or the y axis if x is up. `elevation` is the angle above the horizon, -1.57 to
// 1.57. `distance` is in the caller's units; 0: that of the default camera. `up`, three numbers
// of any length; null: what the file says, else z. A width and height of 0 mean the file's own size. Forward-facing
// captures have no back, and are refused.
PnrfStatus pnrf_orbit_camera(const struct PnrfModel *model,
                             float azimuth,
                             float elevation,
                             float distance,
                             const float *up,
                             uint32_t width,
                             uint32_t height,
                             struct PnrfCamera *camera,
                             struct PnrfError *error);

// Writes what the file says of the caller's coordinates: to `up` the direction that is up, three
// numbers, a unit vector, z where the file says nothing; to `metres_per_unit` how long their unit
// is, 0 where the file says nothing. Either may be null.
PnrfStatus pnrf_world(const struct PnrfModel *model,
                      float *up,
                      float *metres_per_unit,
                      struct PnrfError *error);

// How many photographs' cameras the file has: an even choice of at most 64; 0 for null. People who
// look from there see what photographs have seen.
uint32_t pnrf_photograph_count(const struct PnrfModel *model);

// Makes the camera of a photograph, `number` from 0 to `pnrf_photograph_count` - 1, in the
// dataset's order, with the median of their focal lengths. A width and height of 0 mean the file's
// own size.
PnrfStatus pnrf_photograph_camera(const struct PnrfModel *model,
                                  uint32_t number,
                                  uint32_t width,
                                  uint32_t height,
                                  struct PnrfCamera *camera,
                                  struct PnrfError *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* POCKETNERF_H */
