/* What a program may do wrong, and that it is told so: misuse MODEL.pnerf NEWER.pnerf
 * Buffers end, and others begin, at pages that cannot be touched. */
#define _DEFAULT_SOURCE
#include <math.h>
#include <pocketnerf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static int failures = 0;
static PnrfError told;

static void expect(PnrfStatus found, PnrfStatus expected, const char *what) {
    int texts = (found != PNRF_STATUS_OK) == (told.text[0] != 0) && told.status == found;
    if (found == expected && texts) return;
    fprintf(stderr, "%s: status %d (%s), expected %d\n", what, (int)found, told.text,
            (int)expected);
    failures++;
}
#define EXPECT(status, call) expect((call), PNRF_STATUS_##status, #call)

static void that(int is_so, const char *what) {
    if (is_so) return;
    fprintf(stderr, "not so: %s\n", what);
    failures++;
}
#define THAT(is_so) that((is_so), #is_so)

enum { PAGE = 4096 };

/* Room for `size` bytes between two pages that cannot be touched; where `at_end`, it ends
 * where the second begins, else it begins where the first ends. */
static void *guarded(size_t size, int at_end) {
    size_t pages = (size + PAGE - 1) / PAGE;
    unsigned char *all = mmap(NULL, (pages + 2) * PAGE, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED) exit(2);
    mprotect(all, PAGE, PROT_NONE);
    mprotect(all + (pages + 1) * PAGE, PAGE, PROT_NONE);
    memset(all + PAGE, 0xa5, pages * PAGE);
    return all + PAGE + (at_end ? pages * PAGE - size : 0);
}

static unsigned char *slurp(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    if (!file) exit(2);
    unsigned char *bytes = malloc(1 << 20);
    *length = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

static PnrfModel *model;
static PnrfCamera camera;
static float *scratch;
static size_t length;

static void opening(const char *path, const char *newer) {
    size_t n, n_newer;
    unsigned char *bytes = slurp(path, &n), *later = slurp(newer, &n_newer);
    PnrfModel *none = (PnrfModel *)&told;
    EXPECT(NULL, pnrf_open_file(NULL, 0, &none, &told));
    THAT(none == NULL);
    EXPECT(NULL, pnrf_open_file(path, 0, NULL, &told));
    EXPECT(FILE, pnrf_open_file("/nowhere/at all", 0, &none, &told));
    THAT(strstr(told.text, "/nowhere/at all") != NULL);
    EXPECT(FILE, pnrf_open_file("/", 0, &none, &told));
    EXPECT(ARGUMENT, pnrf_open_file(path, PNRF_OPEN_BORROWED, &none, &told));
    EXPECT(ARGUMENT, pnrf_open_file(path, 1u << 31, &none, &told));
    EXPECT(NULL, pnrf_open_bytes(NULL, n, 0, &none, &told));
    EXPECT(ARGUMENT, pnrf_open_bytes(bytes, SIZE_MAX, 0, &none, &told));
    EXPECT(NOT_A_MODEL, pnrf_open_bytes(bytes, 0, 0, &none, &told));
    EXPECT(NOT_A_MODEL, pnrf_open_bytes("hello, world, this is no model", 30, 0, &none, &told));
    EXPECT(DAMAGED, pnrf_open_bytes(bytes, n - 1, 0, &none, &told));
    EXPECT(VERSION, pnrf_open_bytes(later, n_newer, 0, &none, &told));
    bytes[n - 1] ^= 1;
    EXPECT(DAMAGED, pnrf_open_bytes(bytes, n, 0, &none, &told));
    bytes[n - 1] ^= 1;
    /* Major version 7. */
    unsigned char major = bytes[8];
    bytes[8] = 7;
    EXPECT(VERSION, pnrf_open_bytes(bytes, n, 0, &none, &told));
    bytes[8] = major;
    THAT(none == NULL);
    pnrf_close(NULL);
    /* Misaligned bytes are as good as any. */
    unsigned char reference[4 * 8 * 6], found[4 * 8 * 6];
    for (size_t at = 0; at < 9; at++) {
        unsigned char *moved = malloc(n + at);
        memcpy(moved + at, bytes, n);
        PnrfModel *open;
        PnrfCamera small;
        EXPECT(OK, pnrf_open_bytes(moved + at, n, PNRF_OPEN_BORROWED, &open, &told));
        EXPECT(OK, pnrf_default_camera(open, 8, 6, &small, &told));
        PnrfImage image;
        memset(&image, 0, sizeof image);
        image.pixels = at ? found : reference;
        image.size = sizeof found;
        EXPECT(OK, pnrf_render(open, &small, NULL, &image, scratch, length, NULL, &told));
        THAT(at == 0 || !memcmp(reference, found, sizeof found));
        pnrf_close(open);
        free(moved);
    }
    free(bytes);
    free(later);
}

static void cameras(void) {
    unsigned char pixels[4 * 8 * 6];
    PnrfImage image;
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.size = sizeof pixels;
    memset(pixels, 0x5a, sizeof pixels);
#define BROKEN(change)                                                                      \
    do {                                                                                    \
        PnrfCamera broken = camera;                                                         \
        change;                                                                             \
        EXPECT(CAMERA, pnrf_render(model, &broken, NULL, &image, scratch, length, NULL, &told)); \
    } while (0)
    BROKEN(broken.width = 0);
    BROKEN(broken.height = 0);
    BROKEN(broken.width = UINT32_MAX);
    BROKEN(broken.height = PNRF_MAX_SIDE + 1);
    BROKEN(broken.focal[0] = 0);
    BROKEN(broken.focal[1] = -3);
    BROKEN(broken.focal[1] = NAN);
    BROKEN(broken.center[0] = INFINITY);
    for (int i = 0; i < 12; i++) BROKEN(broken.camera_to_world[i] = NAN);
    for (int i = 0; i < 12; i++) BROKEN(broken.camera_to_world[i] = INFINITY);
    /* Mirrored, as left-handed engines have it. */
    BROKEN(for (int i = 0; i < 3; i++) broken.camera_to_world[4 * i] *= -1);
    BROKEN(for (int i = 0; i < 3; i++) broken.camera_to_world[4 * i] *= 2);
    for (size_t i = 0; i < sizeof pixels; i++) THAT(pixels[i] == 0x5a);

    float eye[3] = {1, 2, 3}, target[3] = {0, 0, NAN}, up[3] = {0, 0, 1};
    PnrfCamera made = camera;
    EXPECT(ARGUMENT, pnrf_look_at(eye, target, up, 0.7f, 8, 6, &made, &told));
    target[2] = 0;
    EXPECT(ARGUMENT, pnrf_look_at(eye, target, up, 0, 8, 6, &made, &told));
    EXPECT(ARGUMENT, pnrf_look_at(eye, target, up, NAN, 8, 6, &made, &told));
    EXPECT(NULL, pnrf_look_at(NULL, target, up, 0.7f, 8, 6, &made, &told));
    EXPECT(NULL, pnrf_look_at(eye, target, up, 0.7f, 8, 6, NULL, &told));
    THAT(!memcmp(&made, &camera, sizeof made));
    EXPECT(CAMERA, pnrf_default_camera(model, 0, 5, &made, &told));
    EXPECT(NULL, pnrf_default_camera(NULL, 8, 6, &made, &told));
    float flat[3] = {0, 0, 0};
    EXPECT(ARGUMENT, pnrf_orbit_camera(model, 0, 0, 0, flat, 8, 6, &made, &told));
    EXPECT(ARGUMENT, pnrf_orbit_camera(model, INFINITY, 0, 0, NULL, 8, 6, &made, &told));
    EXPECT(CAMERA, pnrf_orbit_camera(model, 0, 0, 0, NULL, 8, 0, &made, &told));
    EXPECT(NULL, pnrf_orbit_camera(model, 0, 0, 0, NULL, 8, 6, NULL, &told));
    EXPECT(ARGUMENT, pnrf_photograph_camera(model, 0, 8, 6, &made, &told));
    THAT(!memcmp(&made, &camera, sizeof made));
}

static void images(void) {
    enum { W = 37, H = 21 };
    PnrfCamera view;
    EXPECT(OK, pnrf_default_camera(model, W, H, &view, &told));
    PnrfImage none, image;
    memset(&none, 0, sizeof none);
#define RENDER() pnrf_render(model, &view, NULL, &image, scratch, length, NULL, &told)
    image = none;
    EXPECT(NULL, RENDER());
    EXPECT(NULL, pnrf_render(model, &view, NULL, NULL, scratch, length, NULL, &told));
    EXPECT(NULL, pnrf_render(model, NULL, NULL, &none, scratch, length, NULL, &told));
    EXPECT(NULL, pnrf_render(NULL, &view, NULL, &none, scratch, length, NULL, &told));
    for (int at_end = 0; at_end < 2; at_end++) {
        for (uint32_t format = 0; format < 3; format++) {
            size_t pixel = format == PNRF_FORMAT_RGBA_F32 ? 16 : 4;
            for (size_t gap = 0; gap < 8; gap += 7) {
                size_t stride = W * pixel + gap, size = stride * (H - 1) + W * pixel;
                unsigned char *pixels = guarded(size, at_end), *depth = guarded(4 * W * H, at_end);
                image = none;
                image.format = format;
                image.pixels = pixels;
                image.size = size - 1;
                image.stride = stride;
                EXPECT(BUFFER, RENDER());
                image.size = size;
                image.depth = (float *)(void *)depth;
                image.depth_size = 4 * W * H - 1;
                EXPECT(BUFFER, RENDER());
                THAT(pixels[0] == 0xa5 && pixels[size - 1] == 0xa5 && depth[0] == 0xa5);
                image.depth_size++;
                image.bottom_up = (uint32_t)at_end;
                EXPECT(OK, RENDER());
                /* What lies between rows is left alone. */
                for (size_t y = 0; y + 1 < H; y++)
                    for (size_t i = 0; i < gap; i++)
                        THAT(pixels[y * stride + W * pixel + i] == 0xa5);
                image.stride = W * pixel - 1;
                EXPECT(BUFFER, RENDER());
                image.stride = SIZE_MAX / 2;
                EXPECT(BUFFER, RENDER());
            }
        }
    }
    unsigned char pixels[4 * W * H];
    none.pixels = pixels;
    none.size = sizeof pixels;
    memset(pixels, 0x5a, sizeof pixels);
    EXPECT(ARGUMENT, (image = none, image.format = 3, RENDER()));
    EXPECT(ARGUMENT, (image = none, image.alpha = UINT32_MAX, RENDER()));
    EXPECT(ARGUMENT, (image = none, image.depth_kind = 2, RENDER()));
    EXPECT(ARGUMENT, (image = none, image.bottom_up = 2, RENDER()));
    EXPECT(ARGUMENT, (image = none, image.background[1] = NAN, RENDER()));
    image = none;
    EXPECT(NULL, pnrf_render(model, &view, NULL, &image, NULL, length, NULL, &told));
    EXPECT(BUFFER, pnrf_render(model, &view, NULL, &image, scratch, length - 1, NULL, &told));
    EXPECT(BUFFER, pnrf_render(model, &view, NULL, &image, scratch, 0, NULL, &told));
    float *odd = (float *)(void *)((char *)scratch + 1);
    EXPECT(MISALIGNED, pnrf_render(model, &view, NULL, &image, odd, length, NULL, &told));
    PnrfStats *wild = (PnrfStats *)(void *)((char *)&told + 1);
    EXPECT(MISALIGNED, pnrf_render(model, &view, NULL, &image, scratch, length, wild, &told));
    uint32_t n = pnrf_tile_count(W, H, NULL);
    THAT(n > 0 && pnrf_tile_count(0, H, NULL) == 0 && pnrf_tile_count(W, UINT32_MAX, NULL) == 0);
    PnrfTile tile = {7, 7, 7, 7};
    EXPECT(ARGUMENT, pnrf_tile(W, H, NULL, n, &tile, &told));
    EXPECT(ARGUMENT, pnrf_tile(W, 0, NULL, 0, &tile, &told));
    THAT(tile.x == 7);
    EXPECT(ARGUMENT,
           pnrf_render_tile(model, &view, NULL, n, &image, scratch, length, NULL, &told));
    for (size_t i = 0; i < sizeof pixels; i++) THAT(pixels[i] == 0x5a);
}

static void options(void) {
    PnrfOptions usual;
    size_t needed = 7;
    EXPECT(NULL, pnrf_default_options(NULL, &told));
    EXPECT(OK, pnrf_default_options(&usual, &told));
#define BAD(status, change)                                              \
    do {                                                                 \
        PnrfOptions bad = usual;                                         \
        change;                                                          \
        EXPECT(status, pnrf_scratch_length(model, &bad, &needed, &told)); \
    } while (0)
    BAD(ARGUMENT, bad.simd = 6);
    BAD(ARGUMENT, bad.memory = 2);
    BAD(ARGUMENT, bad.sampling = 2);
    BAD(ARGUMENT, bad.quality = NAN);
#if defined(__x86_64__)
    BAD(NO_SIMD, bad.simd = PNRF_SIMD_NEON);
#endif
    THAT(needed == 7);
}

static void questions(void) {
    float points[6] = {0, 0, 0, 0.1f, 0, 0}, nowhere[3] = {0, NAN, 0}, out[8] = {-7};
    unsigned char flags[2] = {9, 9};
    EXPECT(NULL, pnrf_density(model, NULL, NULL, 1, out, scratch, length, &told));
    EXPECT(NULL, pnrf_density(model, NULL, points, 1, NULL, scratch, length, &told));
    EXPECT(NULL, pnrf_density(NULL, NULL, points, 1, out, scratch, length, &told));
    EXPECT(BUFFER, pnrf_density(model, NULL, points, 1, out, scratch, 100, &told));
    EXPECT(ARGUMENT, pnrf_density(model, NULL, nowhere, 1, out, scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_density(model, NULL, points, SIZE_MAX, out, scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_normals(model, NULL, points, SIZE_MAX / 3, out, scratch, length, &told));
    float *odd = (float *)(void *)((char *)points + 1);
    EXPECT(MISALIGNED, pnrf_density(model, NULL, odd, 1, out, scratch, length, &told));
    float still[3] = {0, 0, 0};
    EXPECT(ARGUMENT, pnrf_radiance(model, NULL, points, still, 1, out, scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_depths(model, NULL, points, 1, 4, 0, NULL, out, scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_depths(model, NULL, points, 1, PNRF_DEPTH_FIRST_OPACITY, 1, NULL, out,
                                 scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_collision_probability(model, NULL, points, 2, -1, 1, out, scratch,
                                                length, &told));
    EXPECT(ARGUMENT, pnrf_collision_probability(model, NULL, points, 2, 1, 0, out, scratch,
                                                length, &told));
    THAT(out[0] == -7);
    PnrfHit hit = {-7, {-7, -7, -7}, {-7, -7, -7}};
    EXPECT(NULL, pnrf_pick(model, NULL, NULL, points, 1, &hit, scratch, length, &told));
    EXPECT(NULL, pnrf_pick(model, NULL, &camera, points, 1, NULL, scratch, length, &told));
    EXPECT(BUFFER, pnrf_pick(model, NULL, &camera, points, 1, &hit, scratch, 0, &told));
    EXPECT(ARGUMENT,
           pnrf_pick(model, NULL, &camera, points, SIZE_MAX / 4, &hit, scratch, length, &told));
    EXPECT(ARGUMENT, pnrf_pick(model, NULL, &camera, nowhere, 1, &hit, scratch, length, &told));
    THAT(hit.depth == -7 && hit.normal[2] == -7);
    EXPECT(NULL, pnrf_occupied(model, points, 2, NULL, &told));
    EXPECT(OK, pnrf_occupied(model, nowhere, 1, flags, &told));
    THAT(flags[0] == 1 && flags[1] == 9);
    float ball[4] = {NAN, 0, 0, 1};
    EXPECT(OK, pnrf_sphere_clear(model, ball, 1, flags, &told));
    THAT(flags[0] == 0 && flags[1] == 9);
    /* Nothing to be asked needs no memory for it. */
    EXPECT(OK, pnrf_density(model, NULL, NULL, 0, NULL, scratch, length, &told));
    EXPECT(OK, pnrf_occupied(model, NULL, 0, NULL, &told));
    char small[2] = {'x', 'y'};
    size_t needed = 0;
    EXPECT(BUFFER, pnrf_text(model, PNRF_TEXT_KIND, small, 2, &needed, &told));
    THAT(needed == strlen("hash-grid") + 1 && small[0] == 'x');
    EXPECT(ARGUMENT, pnrf_text(model, 5, small, 2, NULL, &told));
    EXPECT(NULL, pnrf_info(model, NULL, &told));
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    THAT(pnrf_abi_version() == PNRF_ABI_VERSION);
    EXPECT(OK, pnrf_open_file(argv[1], 0, &model, &told));
    EXPECT(OK, pnrf_default_camera(model, 8, 6, &camera, &told));
    EXPECT(OK, pnrf_scratch_length(model, NULL, &length, &told));
    scratch = guarded(length * sizeof *scratch, 1);
    opening(argv[1], argv[2]);
    cameras();
    images();
    options();
    questions();
    /* Nobody has to be told. */
    THAT(pnrf_info(NULL, NULL, NULL) == PNRF_STATUS_NULL);
    pnrf_close(model);
    if (!failures) puts("all of it refused");
    return failures != 0;
}
