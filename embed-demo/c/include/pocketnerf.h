/* pocketnerf: radiance fields from .pnerf files, on the CPU.
 *
 * Made by cbindgen from embed-demo/c/src: do not edit.
 *
 * Every function that may fail returns a PnrfStatus and, where it is given a place for one, fills a
 * PnrfError: one line about what was found and what was expected. Outputs are left as they were then.
 * There is no global state, no thread is started, and nothing is printed. A model never changes once
 * it is open, so that any number of threads may use it; scratch is one thread's alone.
 *
 * Coordinates, lengths and densities are those of the photographs that a model was made from
 * (unless it was opened with PNRF_OPEN_MODEL_COORDINATES). Memory that is written to during a call
 * must not overlap any other that the call is given.
 */

#ifndef POCKETNERF_H
#define POCKETNERF_H

#include <stddef.h>
#include <stdint.h>

// The version of this interface: 65536 times the major number, plus the minor. Within a major
// number nothing that is there changes; the minor grows with what is added.
#define PNRF_ABI_VERSION 65536

// Pixels along a side of a picture at most.
#define PNRF_MAX_SIDE 16384

// [`pnrf_open_bytes`]: the bytes are not copied. They stay where they are, as they are, until
// the model is closed.
#define PNRF_OPEN_BORROWED 1

// Checksums and weights are not looked at: opens at once, whatever the size. Damaged
// weights then give wrong pictures, but never a crash.
#define PNRF_OPEN_UNVERIFIED 2

// Without the table of empty space: less memory (see `table_bytes` of the info), the same
// pictures, 10 to 15 % more time.
#define PNRF_OPEN_WITHOUT_TABLE 4

// Cameras, points and lengths are in the model's own coordinates and units instead of
// those of the photographs it was made from.
#define PNRF_OPEN_MODEL_COORDINATES 8

// Bytes of an error's text, the final zero included.
#define PNRF_ERROR_TEXT 252

// What has become of a call.
enum PnrfStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // It did what it was asked to.
    PNRF_STATUS_OK = 0,
    // A pointer is null that must not be.
    PNRF_STATUS_NULL = 1,
    // A pointer is not a multiple of its type's size. (Pixels, depths and the bytes of a
    // model may lie anywhere.)
    PNRF_STATUS_MISALIGNED = 2,
    // A number is outside its range, not a number, or no code of its kind.
    PNRF_STATUS_ARGUMENT = 3,
    // A camera without pixels, with numbers that are not finite, or with a pose that is
    // no rotation.
    PNRF_STATUS_CAMERA = 4,
    // A buffer is shorter than what is to be written.
    PNRF_STATUS_BUFFER = 5,
    // A file could not be read.
    PNRF_STATUS_FILE = 6,
    // The bytes are those of no model.
    PNRF_STATUS_NOT_A_MODEL = 7,
    // The model was written in a format, or has parts, that this library does not know.
    PNRF_STATUS_VERSION = 8,
    // The model's bytes are damaged.
    PNRF_STATUS_DAMAGED = 9,
    // This model has no answer to the question.
    PNRF_STATUS_UNSUPPORTED = 10,
    // This machine has no such vector instructions.
    PNRF_STATUS_NO_SIMD = 11,
    // A mistake in the library itself.
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

// What counts as the depth of a ray that sees more than one thing.
enum PnrfDepth
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The mean over what is seen, as in a rendered depth.
    PNRF_DEPTH_EXPECTED = 0,
    // Where half of the light has been held back.
    PNRF_DEPTH_MEDIAN = 1,
    // The first sample with a sigma above the threshold, 1 / unit: transparent things
    // too (Dex-NeRF).
    PNRF_DEPTH_FIRST_SIGMA = 2,
    // Where a part of the light, the threshold, from 1e-6 to below 1, has been held back.
    PNRF_DEPTH_FIRST_OPACITY = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfDepth PnrfDepth;
#else
typedef uint32_t PnrfDepth;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a depth is the distance of.
enum PnrfDepthKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // From the camera's position, along the ray.
    PNRF_DEPTH_KIND_DISTANCE = 0,
    // From the plane through the camera, along the direction it looks in: what a z-buffer is
    // made from.
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
    // Four bytes: blue, green, red, alpha, as many window systems have it.
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

// How much memory a call works in.
enum PnrfMemory
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Up to 1.2 MB for a grid: what a core's second-level cache holds.
    PNRF_MEMORY_FAST = 0,
    // A few tens of kilobytes. Tiles are smaller, so that pictures differ a little (within
    // what the quality allows); slower.
    PNRF_MEMORY_SMALL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfMemory PnrfMemory;
#else
typedef uint32_t PnrfMemory;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where along a ray the field is asked.
enum PnrfSampling
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // In occupied cells, until next to no light passes.
    PNRF_SAMPLING_OCCUPANCY = 0,
    // As in the paper, or as the model says; quality changes nothing. Much slower.
    PNRF_SAMPLING_PAPER = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum PnrfSampling PnrfSampling;
#else
typedef uint32_t PnrfSampling;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Vector instructions. Asking for some that the machine lacks is an error.
enum PnrfSimd
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The best that this machine has.
    PNRF_SIMD_DETECT = 0,
    // What every machine has that the library is for.
    PNRF_SIMD_PORTABLE = 1,
    // x86-64-v2: 4 lanes.
    PNRF_SIMD_SSE42 = 2,
    // x86-64-v3: 8 lanes.
    PNRF_SIMD_AVX2 = 3,
    // Ice Lake and Zen 4 upwards: 16 lanes.
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

// What is known of a model, in words.
enum PnrfText
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // What people call the scene.
    PNRF_TEXT_NAME = 0,
    // The kind of its field: hash-grid or nerf.
    PNRF_TEXT_KIND = 1,
    // How it was trained, or from what it was converted.
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

// A model that is open. Nothing in it ever changes: any number of threads may use it at
// the same time.
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
    // Principal point in x and y, pixels from the top left corner. A part of a picture is
    // taken by moving it and making the picture smaller.
    float center[2];
    // 4x4 camera-to-world matrix, row after row: columns are right, up, back (unit
    // vectors) and the camera's position. The last row is not read.
    float camera_to_world[16];
} PnrfCamera;

// A status with a line about what was found and what was expected. Every call that may
// fail fills the one it is given; null: not wanted.
typedef struct PnrfError {
    // The same as the call returns.
    PnrfStatus status;
    // One line of UTF-8 that ends with a zero; empty where all went well.
    char text[PNRF_ERROR_TEXT];
} PnrfError;

// What is known of a model, in numbers.
typedef struct PnrfInfo {
    // Length of the file.
    uint64_t bytes;
    // Weights.
    uint64_t parameters;
    // What the open model takes beside its bytes: the table of empty space.
    uint64_t table_bytes;
    // Part of the model's box that may hold something; 1 where that is not known.
    float occupancy;
    // The middle of its box, caller's coordinates.
    float center[3];
    // Of the ball around the box, caller's units.
    float radius;
    // Smallest corner of the box, model's coordinates.
    float box_min[3];
    // Largest corner of the box, model's coordinates.
    float box_max[3];
    // Caller's units per unit of the model: caller = scale * rotation * model +
    // translation.
    float scale;
    // Rotation of that, row after row.
    float rotation[9];
    // Translation of that.
    float translation[3];
    // Distance between samples along a ray, caller's units.
    float step;
    // The model's background, 0 to 1, in its own colour space.
    float background[3];
    // 1: colours, the background's too, are linear light, and only pictures in bytes are
    // encoded as sRGB; 0: all colours are sRGB, like those of image files.
    uint32_t is_linear;
    // 1: the model can be asked about points, segments and rays; 0: it has normalised
    // device coordinates, and pictures only.
    uint32_t has_queries;
    // 1: the file has a view of its own; see `pnrf_default_camera`.
    uint32_t has_camera;
    // The quality that pictures have where nobody chooses.
    float quality;
} PnrfInfo;

// How to render and to ask. Filled in by `pnrf_default_options`; null instead means just
// these.
typedef struct PnrfOptions {
    // A `PnrfSimd`.
    uint32_t simd;
    // A `PnrfSampling`.
    uint32_t sampling;
    // A `PnrfMemory`.
    uint32_t memory;
    // From 0, the fastest, to 1, the finest; below 0: what the file says, 0.5 as a rule.
    float quality;
} PnrfOptions;

// A whole picture in the caller's memory, rows from top to bottom; what no tile covers is
// not touched, nor is what lies between rows. Memory may be at any address. Set all of it to
// zero first: that is a usual picture, RGBA in bytes against black, without depth and with
// nothing between rows.
typedef struct PnrfImage {
    // The upper left pixel; null: only depth is wanted.
    void *pixels;
    // Bytes that `pixels` has room for.
    size_t size;
    // Bytes from a row to the next; 0: nothing lies between rows.
    size_t stride;
    // A `PnrfFormat`.
    uint32_t format;
    // A `PnrfAlpha`.
    uint32_t alpha;
    // Red, green and blue, 0 to 1, for `PNRF_ALPHA_BACKGROUND`: in the model's own colour
    // space, as in `PnrfInfo`.
    float background[3];
    // 1: rows from bottom to top, as in OpenGL's textures. Of depth too.
    uint32_t bottom_up;
    // One `float` a pixel: the expected distance in the caller's units, infinite where
    // nothing is seen. Null: not wanted.
    float *depth;
    // Bytes that `depth` has room for.
    size_t depth_size;
    // Bytes from a row to the next; 0: nothing lies between rows.
    size_t depth_stride;
    // A `PnrfDepthKind`.
    uint32_t depth_kind;
} PnrfImage;

// What rendering took. To be summed up over tiles.
typedef struct PnrfStats {
    // Rays cast; the other pixels are interpolated, or known to be empty.
    uint64_t rays;
    // Points at which the field was asked.
    uint64_t samples;
    // Rays along which it was asked at all.
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

// The version that the library was built with, to be compared with the header's
// `PNRF_ABI_VERSION`: the upper 16 bits equal, the lower ones not smaller.
uint32_t pnrf_abi_version(void);

// A camera at `eye` that looks at `target`, three numbers each. `up` is where up is in
// the picture, roughly, of any length; `fov_x` the horizontal field of view in radians,
// 0.01 to 3.1.
PnrfStatus pnrf_look_at(const float *eye,
                        const float *target,
                        const float *up,
                        float fov_x,
                        uint32_t width,
                        uint32_t height,
                        struct PnrfCamera *camera,
                        struct PnrfError *error);

// A camera that shows the model: the file's own view, or, where it has none, one from
// aside and above, z up. 0 for width and height: the file's own size.
PnrfStatus pnrf_default_camera(const struct PnrfModel *model,
                               uint32_t width,
                               uint32_t height,
                               struct PnrfCamera *camera,
                               struct PnrfError *error);

// What is known of a model, in numbers.
PnrfStatus pnrf_info(const struct PnrfModel *model, struct PnrfInfo *info, struct PnrfError *error);

// A text of the model's, in UTF-8 with a zero at its end; empty where the file says
// nothing. `which`: a `PnrfText`. `capacity`: bytes that `buffer` holds. `length`, where
// wanted, is told the bytes that are needed, the zero included, even where they are more than
// there is room for: that is an error.
PnrfStatus pnrf_text(const struct PnrfModel *model,
                     uint32_t which,
                     char *buffer,
                     size_t capacity,
                     size_t *length,
                     struct PnrfError *error);

// Opens a file; reads all of it, so that it may change or vanish afterwards.
//
// `path` is UTF-8 on Windows, any bytes elsewhere. `flags`: `PNRF_OPEN_…`, or 0. Writes to
// `model` what `pnrf_close` takes; null where the call fails.
PnrfStatus pnrf_open_file(const char *path,
                          uint32_t flags,
                          struct PnrfModel **model,
                          struct PnrfError *error);

// Opens a model that lies in memory: `length` bytes, at any alignment.
//
// `flags`: `PNRF_OPEN_…`, or 0, in which case the bytes are copied. Writes to `model` what
// `pnrf_close` takes; null where the call fails.
PnrfStatus pnrf_open_bytes(const void *bytes,
                           size_t length,
                           uint32_t flags,
                           struct PnrfModel **model,
                           struct PnrfError *error);

// Closes a model that nobody uses any more. Null is nothing to close.
void pnrf_close(struct PnrfModel *model);

// The usual options, for whoever wants to change some of them.
PnrfStatus pnrf_default_options(struct PnrfOptions *options, struct PnrfError *error);

// How many `float` values of scratch a call needs, for any picture of this model and for
// all questions. Each thread needs its own; they may hold anything, and hold nothing of
// use afterwards.
PnrfStatus pnrf_scratch_length(const struct PnrfModel *model,
                               const struct PnrfOptions *options,
                               size_t *length,
                               struct PnrfError *error);

// Sigma at `n` points, three numbers each, into one value each of `sigma`: the part of the
// light held back per unit of length, 1 / unit; 0 where nothing is.
PnrfStatus pnrf_density(const struct PnrfModel *model,
                        const struct PnrfOptions *options,
                        const float *points,
                        size_t n,
                        float *sigma,
                        float *scratch,
                        size_t scratch_length,
                        struct PnrfError *error);

// Colour and sigma of `n` points, three numbers each, seen along `directions`, three
// numbers each, into four values each of `rgb_sigma`: red, green and blue, straight, 0 to 1,
// and sigma, 1 / unit. All are 0 where nothing is.
PnrfStatus pnrf_radiance(const struct PnrfModel *model,
                         const struct PnrfOptions *options,
                         const float *points,
                         const float *directions,
                         size_t n,
                         float *rgb_sigma,
                         float *scratch,
                         size_t scratch_length,
                         struct PnrfError *error);

// The slope of sigma at `n` points, three numbers each, into three values each of
// `gradient`, 1 / unit^2.
PnrfStatus pnrf_density_gradient(const struct PnrfModel *model,
                                 const struct PnrfOptions *options,
                                 const float *points,
                                 size_t n,
                                 float *gradient,
                                 float *scratch,
                                 size_t scratch_length,
                                 struct PnrfError *error);

// Where surfaces at `n` points face, three numbers each, into a unit vector each of `normals`,
// three numbers; zeros where sigma has no slope.
PnrfStatus pnrf_normals(const struct PnrfModel *model,
                        const struct PnrfOptions *options,
                        const float *points,
                        size_t n,
                        float *normals,
                        float *scratch,
                        size_t scratch_length,
                        struct PnrfError *error);

// Whether there may be something at `n` points, three numbers each, into one byte each of
// `occupied`: 0 or 1. Points that are nowhere (NaN) count as occupied.
PnrfStatus pnrf_occupied(const struct PnrfModel *model,
                         const float *points,
                         size_t n,
                         uint8_t *occupied,
                         struct PnrfError *error);

// Whether `n` balls, centre and radius in four numbers each, are free, into one byte each of
// `clear`: 1 where no occupied cell touches the ball, else 0. Never 1 by mistake; balls that are
// nowhere (NaN) are not clear.
PnrfStatus pnrf_sphere_clear(const struct PnrfModel *model,
                             const float *balls,
                             size_t n,
                             uint8_t *clear,
                             struct PnrfError *error);

// The part of the light that passes along `n` segments, from point to point in six numbers
// each, into one value each of `passes`: 1 where nothing is in the way.
PnrfStatus pnrf_segment_transmittance(const struct PnrfModel *model,
                                      const struct PnrfOptions *options,
                                      const float *segments,
                                      size_t n,
                                      float *passes,
                                      float *scratch,
                                      size_t scratch_length,
                                      struct PnrfError *error);

// The probability that a body hits something (CATNIPS): 1 - exp(-sum of sigma * volume /
// particle_area) over the `n` points that fill it, three numbers each, of which each stands
// for `volume`, unit^3. `particle_area`, unit^2, says how large a thing must be to matter.
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

// How far `n` rays see, origin and direction in six numbers each, into one value each of
// `depths`, units; infinite where a ray sees nothing of the kind.
//
// `kind`: a `PnrfDepth`, with its `threshold`. `axis`, three numbers: depths along that direction, such as
// a camera's, instead of along the ray; null: along the ray.
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
// `image` has room for all of the camera's picture. `scratch`: `scratch_length` values, at
// least `pnrf_scratch_length`. `stats`: null where not wanted. Where the call fails, nothing
// has been written, except to `error`.
PnrfStatus pnrf_render(const struct PnrfModel *model,
                       const struct PnrfCamera *camera,
                       const struct PnrfOptions *options,
                       const struct PnrfImage *image,
                       float *scratch,
                       size_t scratch_length,
                       struct PnrfStats *stats,
                       struct PnrfError *error);

// Renders one tile of a picture, `number` from 0 to `pnrf_tile_count` - 1, into its place
// in the image of the whole picture; else as `pnrf_render`, which does so for one tile
// after the other. Several threads may render tiles into one image at the same time, each
// with scratch of its own.
PnrfStatus pnrf_render_tile(const struct PnrfModel *model,
                            const struct PnrfCamera *camera,
                            const struct PnrfOptions *options,
                            uint32_t number,
                            const struct PnrfImage *image,
                            float *scratch,
                            size_t scratch_length,
                            struct PnrfStats *stats,
                            struct PnrfError *error);

// How many tiles a picture of this size is rendered in; 0 where it has no pixels, or options
// that are none. `options` as for rendering.
uint32_t pnrf_tile_count(uint32_t width, uint32_t height, const struct PnrfOptions *options);

// The rectangle that a tile covers, for whoever shows tiles as soon as they are there.
PnrfStatus pnrf_tile(uint32_t width,
                     uint32_t height,
                     const struct PnrfOptions *options,
                     uint32_t number,
                     struct PnrfTile *tile,
                     struct PnrfError *error);

// A status in a few words, whatever the code. Lives as long as the program.
const char *pnrf_status_text(int32_t status);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* POCKETNERF_H */
