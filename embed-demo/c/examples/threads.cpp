// Renders a view on several threads, and says how far away the nearest thing is:
// threads MODEL.pnerf PICTURE.png [THREADS]
//
// c++ -std=c++17 threads.cpp $(pkg-config --cflags --libs pocketnerf libpng) -o threads
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <png.h>
#include <pocketnerf.h>

using Model = std::unique_ptr<PnrfModel, decltype(&pnrf_close)>;

/// Makes an exception of an error.
static void check(PnrfStatus status, const PnrfError &error) {
    if (status != PNRF_STATUS_OK) throw std::runtime_error(error.text);
}

static Model open(const char *path) {
    PnrfModel *model = nullptr;
    PnrfError error;
    check(pnrf_open_file(path, 0, &model, &error), error);
    return Model(model, &pnrf_close);
}

/// Tiles go to whichever thread is free; each has scratch of its own.
static std::vector<unsigned char> picture(const PnrfModel *model, const PnrfCamera &camera,
                                          unsigned n_threads) {
    PnrfInfo info;
    PnrfError error;
    size_t length = 0;
    check(pnrf_info(model, &info, &error), error);
    check(pnrf_scratch_length(model, nullptr, &length, &error), error);
    std::vector<unsigned char> pixels(size_t{4} * camera.width * camera.height);
    PnrfImage image{};
    image.pixels = pixels.data();
    image.size = pixels.size();
    std::copy_n(info.background, 3, image.background);

    const uint32_t n_tiles = pnrf_tile_count(camera.width, camera.height, nullptr);
    std::atomic<uint32_t> next{0};
    std::vector<PnrfError> errors(n_threads);
    auto work = [&](PnrfError &told) {
        std::vector<float> scratch(length);
        for (uint32_t tile; (tile = next++) < n_tiles;)
            if (pnrf_render_tile(model, &camera, nullptr, tile, &image, scratch.data(), length,
                                 nullptr, &told) != PNRF_STATUS_OK)
                return;
    };
    std::vector<std::thread> threads;
    for (auto &told : errors) threads.emplace_back(work, std::ref(told));
    for (auto &thread : threads) thread.join();
    for (auto &told : errors) check(told.status, told);
    return pixels;
}

/// How far away the nearest of the things is that a few rays through the picture see.
static float nearest(const PnrfModel *model, const PnrfCamera &camera) {
    const float *m = camera.camera_to_world;
    std::vector<float> rays;
    for (int y = 1; y < 16; y++)
        for (int x = 1; x < 16; x++) {
            const float right = (x * camera.width / 16.0f - camera.center[0]) / camera.focal[0];
            const float up = (camera.center[1] - y * camera.height / 16.0f) / camera.focal[1];
            for (int row = 0; row < 3; row++) rays.push_back(m[4 * row + 3]);
            for (int row = 0; row < 3; row++)
                rays.push_back(m[4 * row] * right + m[4 * row + 1] * up - m[4 * row + 2]);
        }
    PnrfError error;
    size_t length = 0;
    check(pnrf_scratch_length(model, nullptr, &length, &error), error);
    std::vector<float> scratch(length), depths(rays.size() / 6);
    check(pnrf_depths(model, nullptr, rays.data(), depths.size(), PNRF_DEPTH_MEDIAN, 0, nullptr,
                      depths.data(), scratch.data(), length, &error),
          error);
    return *std::min_element(depths.begin(), depths.end());
}

int main(int argc, char **argv) try {
    if (argc < 3) throw std::runtime_error("expected MODEL.pnerf PICTURE.png [THREADS]");
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const unsigned n_threads = argc > 3 ? std::max(1, std::atoi(argv[3])) : cores;
    const Model model = open(argv[1]);
    PnrfCamera camera;
    PnrfError error;
    check(pnrf_default_camera(model.get(), 0, 0, &camera, &error), error);
    const auto pixels = picture(model.get(), camera, n_threads);

    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = camera.width;
    png.height = camera.height;
    png.format = PNG_FORMAT_RGBA;
    if (!png_image_write_to_file(&png, argv[2], 0, pixels.data(), 0, nullptr))
        throw std::runtime_error(png.message);
    std::printf("%s: %ux%u on %u threads, the nearest thing is %.2f units away\n", argv[2],
                camera.width, camera.height, n_threads, nearest(model.get(), camera));
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
}
