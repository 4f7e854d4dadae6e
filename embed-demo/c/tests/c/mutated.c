/* Opens damaged copies of models through the C interface, and uses those that open:
 * mutated N MODEL.pnerf... Run it under sanitizers: whatever the bytes, nothing is read or
 * written out of bounds, nothing leaks, nothing hangs. */
#include <pocketnerf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER = 32, ENTRY = 48, METADATA = 1800 };

static uint64_t state = 0x9e3779b97f4a7c15u;

static size_t below(size_t n) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (size_t)(state >> 11) % n;
}

static uint64_t number(const unsigned char *at, int size) {
    uint64_t n = 0;
    while (size--) n = n << 8 | at[size];
    return n;
}

static void put_crc(unsigned char *at, const unsigned char *bytes, size_t n) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    crc = ~crc;
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(crc >> 8 * i);
}

/* Makes the checksums right, so that more of the damage gets past them. */
static void repair(unsigned char *file, size_t n) {
    if (n < HEADER) return;
    size_t count = (size_t)number(file + 12, 4);
    if (count > (n - HEADER) / ENTRY) return;
    for (size_t i = 0; i < count; i++) {
        unsigned char *entry = file + HEADER + i * ENTRY;
        uint64_t offset = number(entry + 16, 8), length = number(entry + 24, 8);
        if (offset <= n && length <= n - offset)
            put_crc(entry + 40, file + offset, (size_t)length);
    }
    memset(file + 24, 0, 4);
    put_crc(file + 24, file, HEADER + count * ENTRY);
}

/* A damaged copy in memory of exactly its size. */
static unsigned char *mutate(const unsigned char *golden, size_t n, size_t *length) {
    *length = below(8) == 0 ? below(n + 1) : n;
    unsigned char *copy = malloc(*length ? *length : 1);
    memcpy(copy, golden, *length);
    for (size_t changes = 1 + below(4); changes-- && *length;) {
        size_t end = below(2) && *length > METADATA ? METADATA : *length;
        size_t at = below(end);
        if (below(2))
            copy[at] ^= (unsigned char)(1u << below(8));
        else
            copy[at] = (unsigned char)below(256);
    }
    if (below(4)) repair(copy, *length);
    return copy;
}

static void use(const PnrfModel *model) {
    PnrfInfo info;
    PnrfCamera camera;
    size_t length = 0;
    char text[64];
    pnrf_info(model, &info, NULL);
    for (uint32_t which = 0; which < 6; which++)
        pnrf_text(model, which, text, sizeof text, NULL, NULL);
    PnrfOptions options;
    pnrf_default_options(&options, NULL);
    options.memory = below(2) ? PNRF_MEMORY_SMALL : PNRF_MEMORY_FAST;
    if (pnrf_scratch_length(model, &options, &length, NULL)) return;
    float *scratch = malloc(length * sizeof *scratch);
    if (!pnrf_default_camera(model, 3, 2, &camera, NULL)) {
        unsigned char *pixels = malloc(4 * 3 * 2);
        float depth[3 * 2];
        PnrfImage image;
        memset(&image, 0, sizeof image);
        image.pixels = pixels;
        image.size = 4 * 3 * 2;
        image.depth = depth;
        image.depth_size = sizeof depth;
        pnrf_render(model, &camera, &options, &image, scratch, length, NULL, NULL);
        free(pixels);
    }
    const float *c = info.center;
    float points[6] = {c[0], c[1], c[2], c[0] + 0.1f, c[1], c[2] - 0.1f}, out[8];
    float ball[4] = {c[0], c[1], c[2], 0.1f * info.radius};
    unsigned char flags[2];
    pnrf_density(model, &options, points, 2, out, scratch, length, NULL);
    pnrf_radiance(model, &options, points, points, 2, out, scratch, length, NULL);
    pnrf_normals(model, &options, points, 2, out, scratch, length, NULL);
    pnrf_occupied(model, points, 2, flags, NULL);
    pnrf_sphere_clear(model, ball, 1, flags, NULL);
    pnrf_segment_transmittance(model, &options, points, 1, out, scratch, length, NULL);
    pnrf_depths(model, &options, points, 1, 1, 0, NULL, out, scratch, length, NULL);
    free(scratch);
}

int main(int argc, char **argv) {
    static unsigned char golden[1 << 16];
    int n = argc > 2 ? atoi(argv[1]) : 0, opened = 0, refused = 0;
    for (int i = 0; i < n; i++) {
        FILE *file = fopen(argv[2 + i % (argc - 2)], "rb");
        if (!file) return 1;
        size_t size = fread(golden, 1, sizeof golden, file), length;
        fclose(file);
        unsigned char *bytes = mutate(golden, size, &length);
        uint32_t flags = (uint32_t)below(16);
        PnrfModel *model;
        PnrfError error;
        PnrfStatus status = pnrf_open_bytes(bytes, length, flags, &model, &error);
        if ((status == PNRF_STATUS_OK) != (model != NULL) || status != error.status ||
            status == PNRF_STATUS_INTERNAL || (status && !error.text[0])) {
            fprintf(stderr, "mutation %d: status %d, %s\n", i, (int)status, error.text);
            return 1;
        }
        if (!(flags & PNRF_OPEN_BORROWED)) {
            free(bytes);
            bytes = NULL;
        }
        if (model) use(model);
        model ? opened++ : refused++;
        pnrf_close(model);
        free(bytes);
    }
    printf("%d opened, %d refused\n", opened, refused);
    return n && opened > n / 20 && refused > n / 20 ? 0 : 1;
}
