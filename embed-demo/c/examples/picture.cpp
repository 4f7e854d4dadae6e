// Renders a view on all threads, and says how far away its middle is:
// picture MODEL.pnerf PICTURE.png
//
// c++ -std=c++17 picture.cpp $(pkg-config --cflags --libs pocketnerf libpng) -o picture
#define POCKETNERF_EXCEPTIONS
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include <png.h>
#include <pocketnerf.hpp>

static void save(const char *path, const pocketnerf::Camera &camera,
                 const std::vector<uint8_t> &pixels) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = camera.width;
    png.height = camera.height;
    png.format = PNG_FORMAT_RGBA;
    if (!png_image_write_to_file(&png, path, 0, pixels.data(), 0, nullptr))
        throw std::runtime_error(std::string(path) + ": " + png.message);
}

int main(int argc, char **argv) try {
    if (argc != 3) throw std::runtime_error("expected MODEL.pnerf PICTURE.png");
    const auto model = pocketnerf::Model::open(argv[1]).value();
    const auto camera = model.camera().value();

    std::vector<uint8_t> pixels(size_t{4} * camera.width * camera.height);
    auto image = pocketnerf::Image(pixels).over(model.info()->background);
    const auto stats = model.render(camera, image).value();
    save(argv[2], camera, pixels);

    std::printf("%s: %ux%u, %.0f samples\n", argv[2], camera.width, camera.height,
                static_cast<double>(stats.samples));
    if (model.info()->has_queries) {
        auto worker = model.worker().value();
        const auto middle = worker.pick(camera, camera.center[0], camera.center[1]).value();
        if (std::isfinite(middle.depth))
            std::printf("what is in the middle is %.2f units away\n", middle.depth);
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
}
