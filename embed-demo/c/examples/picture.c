/* Renders the view that a model begins with: picture MODEL.pnerf PICTURE.png
 *
 * cc -std=c99 picture.c $(pkg-config --cflags --libs pocketnerf libpng) -o picture */
#include <png.h>
#include <pocketnerf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int render(const PnrfModel *model, const char *path, PnrfError *error) {
    PnrfInfo info;
    PnrfCamera camera;
    size_t length;
    if (pnrf_info(model, &info, error) || pnrf_default_camera(model, 0, 0, &camera, error) ||
        pnrf_scratch_length(model, NULL, &length, error))
        return 0;

    PnrfImage image;
    memset(&image, 0, sizeof image);
    image.size = (size_t)4 * camera.width * camera.height;
    image.pixels = malloc(image.size);
    memcpy(image.background, info.background, sizeof image.background);
    float *scratch = malloc(length * sizeof *scratch);
    int done = image.pixels && scratch &&
               !pnrf_render(model, &camera, NULL, &image, scratch, length, NULL, error);

    png_image png;
    memset(&png, 0, sizeof png);
    png.version = PNG_IMAGE_VERSION;
    png.width = camera.width;
    png.height = camera.height;
    png.format = PNG_FORMAT_RGBA;
    if (done && !png_image_write_to_file(&png, path, 0, image.pixels, 0, NULL)) {
        snprintf(error->text, sizeof error->text, "%.100s: %.100s", path, png.message);
        done = 0;
    }
    free(scratch);
    free(image.pixels);
    return done;
}

int main(int argc, char **argv) {
    PnrfModel *model;
    PnrfError error = {PNRF_STATUS_OK, "out of memory"};
    if (argc != 3) {
        fprintf(stderr, "usage: %s MODEL.pnerf PICTURE.png\n", argv[0]);
        return 2;
    }
    int done = !pnrf_open_file(argv[1], 0, &model, &error) && render(model, argv[2], &error);
    if (!done) fprintf(stderr, "%s: %s\n", argv[0], error.text);
    pnrf_close(model);
    return done ? 0 : 1;
}
