/* What memory calls take: stack MODEL.pnerf
 * Each runs on a thread whose stack was painted; what is no longer paint was used. */
#include <pocketnerf.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STACK = 1 << 20, PAINT = 0xa5, N = 100 };

static const char *path;
static PnrfModel *model;
static PnrfCamera camera;
static PnrfImage image;
static PnrfOptions options;
static float *scratch, points[3 * N], out[N];
static size_t length;

static void *nothing(void *argument) { return argument; }

static void *open_file(void *status) {
    *(PnrfStatus *)status = pnrf_open_file(path, 0, &model, NULL);
    return NULL;
}

static void *render(void *status) {
    *(PnrfStatus *)status =
        pnrf_render(model, &camera, &options, &image, scratch, length, NULL, NULL);
    return NULL;
}

static void *density(void *status) {
    *(PnrfStatus *)status =
        pnrf_density(model, &options, points, N, out, scratch, length, NULL);
    return NULL;
}

static long used(void *(*work)(void *)) {
    unsigned char *stack = aligned_alloc(4096, STACK);
    memset(stack, PAINT, STACK);
    pthread_attr_t attributes;
    pthread_t thread;
    PnrfStatus status = PNRF_STATUS_OK;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, STACK);
    if (pthread_create(&thread, &attributes, work, &status)) exit(2);
    pthread_join(thread, NULL);
    if (status) exit(2);
    long untouched = 0;
    while (untouched < STACK && stack[untouched] == PAINT) untouched++;
    free(stack);
    return STACK - untouched;
}

int main(int argc, char **argv) {
    if (argc != 2) return 2;
    path = argv[1];
    long thread = used(nothing), opening = used(open_file) - thread;
    PnrfInfo info;
    if (pnrf_info(model, &info, NULL) || pnrf_default_camera(model, 160, 120, &camera, NULL) ||
        pnrf_default_options(&options, NULL))
        return 2;
    image.size = 4 * 160 * 120;
    image.pixels = malloc(image.size);
    printf("file %llu bytes, table %llu\n", (unsigned long long)info.bytes,
           (unsigned long long)info.table_bytes);
    printf("opening: stack %ld\n", opening);
    for (options.memory = 0; options.memory < 2; options.memory++) {
        for (options.simd = 1; options.simd < 5; options.simd++) {
            if (pnrf_scratch_length(model, &options, &length, NULL)) continue;
            scratch = malloc(length * sizeof *scratch);
            long picture = used(render) - thread, question = used(density) - thread;
            printf("%s, SIMD level %u: scratch %zu, stack %ld (picture), %ld (density)\n",
                   options.memory ? "small" : "fast", (unsigned)options.simd, 4 * length, picture,
                   question);
            free(scratch);
        }
    }
    free(image.pixels);
    pnrf_close(model);
    return 0;
}
