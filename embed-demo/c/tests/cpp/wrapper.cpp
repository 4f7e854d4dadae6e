// The wrapper gives what the C interface gives, and says what is wrong: wrapper MODEL.pnerf
// PHOTOGRAPHS.pnerf. With a third argument it takes the value of a failure.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include <pocketnerf.hpp>

using namespace pocketnerf;

static int failures = 0;

static void that(bool is_so, const char *what, int line) {
    if (is_so) return;
    std::fprintf(stderr, "line %d, not so: %s\n", line, what);
    failures++;
}
#define THAT(is_so) that((is_so), #is_so, __LINE__)

/// Whether a call fails with this status and one line, which contains `part`.
template <class T> static bool fails(const Result<T> &result, PnrfStatus status, const char *part) {
    const Error error = result.error();
    if (!result && result.failure() && error.status() == status && std::strstr(error.what(), part) &&
        !std::strchr(error.what(), '\n'))
        return true;
    std::fprintf(stderr, "status %d: %s\n", static_cast<int>(error.status()), error.what());
    return false;
}

/// The calls of pocketnerf.h itself.
struct Plain {
    explicit Plain(const char *path) {
        if (pnrf_open_file(path, 0, &model, &told) != PNRF_STATUS_OK) std::exit(2);
        size_t length = 0;
        pnrf_scratch_length(model, nullptr, &length, &told);
        scratch.resize(length);
    }
    ~Plain() { pnrf_close(model); }
    void render(const PnrfCamera &camera, const PnrfImage &image) {
        const auto status = pnrf_render(model, &camera, nullptr, &image, scratch.data(),
                                        scratch.size(), nullptr, &told);
        THAT(status == PNRF_STATUS_OK);
    }
    PnrfModel *model = nullptr;
    PnrfError told{};
    std::vector<float> scratch;
};

static void pictures(const Model &model, Plain &plain) {
    constexpr uint32_t W = 150, H = 90, STRIDE = 4 * W + 12;
    const Camera camera = *model.camera(W, H);
    std::vector<uint8_t> found(4 * W * H), expected(4 * W * H);
    for (unsigned threads : {0u, 1u, 3u, 1000u}) {
        std::fill(found.begin(), found.end(), uint8_t{1});
        auto image = Image(found).over(model.info()->background);
        const auto stats = model.render(camera, image, {}, threads);
        THAT(stats && stats->rays > 0 && stats->samples > stats->hits);
        image.pixels = expected.data();
        plain.render(camera, image);
        THAT(found == expected);
    }
    // Straight BGRA, upside down, rows with a gap, and z.
    std::vector<uint8_t> padded(STRIDE * H, 7), again(STRIDE * H, 7);
    std::vector<float> z(W * H), z_again(W * H);
    auto image = Image(padded).with_alpha(PNRF_ALPHA_STRAIGHT).with_depth(z, PNRF_DEPTH_KIND_Z);
    image.format = PNRF_FORMAT_BGRA8;
    image.stride = STRIDE;
    image.bottom_up = 1;
    THAT(model.render(camera, image).ok());
    image.pixels = again.data();
    image.depth = z_again.data();
    plain.render(camera, image);
    THAT(padded == again && z == z_again && padded[4 * W] == 7);
    // Floats, by tiles.
    std::vector<float> floats(4 * W * H), floats_again(4 * W * H);
    auto premultiplied = Image(floats).with_alpha(PNRF_ALPHA_PREMULTIPLIED);
    auto worker = model.worker().value();
    const uint32_t n = worker.tile_count(camera);
    THAT(n > 1);
    size_t pixels = 0;
    for (uint32_t number = 0; number < n; number++) {
        THAT(worker.render_tile(camera, number, premultiplied).ok());
        const auto tile = worker.tile(camera, number);
        pixels += size_t{tile->width} * tile->height;
    }
    THAT(pixels == W * H);
    premultiplied.pixels = floats_again.data();
    plain.render(camera, premultiplied);
    THAT(floats == floats_again);

    THAT(fails(worker.render_tile(camera, n, premultiplied), PNRF_STATUS_ARGUMENT, "tiles"));
    std::vector<uint8_t> small(4 * W * H - 1);
    THAT(fails(model.render(camera, Image(small)), PNRF_STATUS_BUFFER, "room for"));
    THAT(fails(model.render(camera, Image()), PNRF_STATUS_NULL, "null"));
    Options options;
    options.quality = NAN;
    THAT(fails(model.render(camera, Image(found), options), PNRF_STATUS_ARGUMENT, "quality"));
    THAT(fails(model.render(Camera{}, Image(found)), PNRF_STATUS_CAMERA, "camera"));
}

static void cameras(const Model &model, const Model &with_photographs) {
    const auto looking = look_at({1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 0.7f, 40, 30);
    std::array<float, 16> matrix;
    std::copy_n(looking->camera_to_world, 16, matrix.begin());
    const Camera same = camera_from(matrix, looking->focal[0], 40, 30);
    THAT(!std::memcmp(&same, &*looking, sizeof same));
    THAT(fails(look_at({NAN, 2, 3}, {0, 0, 0}, {0, 0, 1}, 1, 8, 6), PNRF_STATUS_ARGUMENT, "eye"));
    const auto around = model.orbit(0, 0, 5, {0, 0, 1}, 8, 6);
    THAT(std::fabs(around->camera_to_world[3] - model.info()->center[0] - 5) < 1e-4f);
    THAT(around->width == 8 && around->height == 6);
    // The file says nothing of its world.
    THAT(*model.up() == (Vec3{0, 0, 1}) && *model.metres_per_unit() == 0);
    THAT(fails(model.orbit(0, 3), PNRF_STATUS_ARGUMENT, "elevation"));
    THAT(with_photographs.photograph_count() == 3 && with_photographs.photograph(2).ok());
    THAT(fails(with_photographs.photograph(3), PNRF_STATUS_ARGUMENT, "3 of 3"));
}

static void questions(const Model &model, Plain &plain) {
    auto worker = model.worker().value();
    const Info info = *model.info();
    const Vec3 middle{info.center[0], info.center[1], info.center[2]};
    const std::vector<Vec3> points{middle, {middle[0] + 0.1f, middle[1], middle[2] - 0.2f},
                                   {9, 9, 9}};
    const float *p = points[0].data();
    float *s = plain.scratch.data();
    const size_t length = plain.scratch.size(), n = points.size();

    std::vector<float> sigma(n);
    pnrf_density(plain.model, nullptr, p, n, sigma.data(), s, length, nullptr);
    THAT(*worker.density(points) == sigma);
    std::vector<Vec3> vectors(n);
    pnrf_density_gradient(plain.model, nullptr, p, n, vectors[0].data(), s, length, nullptr);
    THAT(*worker.density_gradient(points) == vectors);
    pnrf_normals(plain.model, nullptr, p, n, vectors[0].data(), s, length, nullptr);
    THAT(*worker.normals(points) == vectors);
    const std::vector<Vec3> directions(n, {0, 1, 0});
    const auto radiance = worker.radiance(points, directions);
    THAT(radiance.ok() && (*radiance)[1].sigma == sigma[1]);
    THAT(fails(worker.radiance(points, {}), PNRF_STATUS_ARGUMENT, "0 directions"));
    const auto passes = worker.transmittance({{points[0], points[0]}, {points[0], points[2]}});
    THAT(passes.ok() && (*passes)[0] == 1 && (*passes)[1] <= 1);
    const auto probability = worker.collision_probability(points, 1e-3f, 1e-2f);
    THAT(probability.ok() && *probability >= 0 && *probability <= 1);
    THAT(*model.occupied({{NAN, 0, 0}}) == std::vector<uint8_t>{1});
    THAT(*model.clear({{{1000, 0, 0}, 1}}) == std::vector<uint8_t>{1});

    const Camera camera = *model.camera(40, 30);
    const auto hit = worker.pick(camera, 20, 20);
    const auto many = worker.pick(camera, std::vector<std::array<float, 2>>{{0, 0}, {20, 20}});
    THAT(hit.ok() && many.ok() && (*many)[1].depth == hit->depth && many->size() == 2);
    const float *m = camera.camera_to_world;
    const Ray ray{{m[3], m[7], m[11]}, {hit->point[0] - m[3], hit->point[1] - m[7], hit->point[2] - m[11]}};
    const auto depths = worker.depths({ray});
    THAT(depths.ok() && std::fabs((*depths)[0] - hit->depth) < 1e-3f * hit->depth);
    THAT(fails(worker.density({{NAN, 0, 0}}), PNRF_STATUS_ARGUMENT, ""));
    THAT(worker.density({})->empty());
}

static void misuse(const char *path) {
    THAT(fails(Model::open("/nowhere/at all"), PNRF_STATUS_FILE, "/nowhere/at all: "));
    THAT(fails(Model::from_bytes("hello", 5), PNRF_STATUS_NOT_A_MODEL, ""));
    THAT(fails(Model::from_bytes(nullptr, 5), PNRF_STATUS_NULL, "null"));
    std::ifstream file(path, std::ios::binary);
    std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    bytes.back() ^= 1;
    THAT(fails(Model::from_bytes(bytes.data(), bytes.size()), PNRF_STATUS_DAMAGED, ""));
    bytes.back() ^= 1;
    auto borrowed = Model::borrow(bytes.data(), bytes.size());
    THAT(borrowed.ok() && borrowed->text(PNRF_TEXT_KIND).value() == "hash-grid");
    THAT(borrowed.error().status() == PNRF_STATUS_OK && !borrowed.failure());

    // A worker keeps its model open; one that was moved from does nothing any more.
    auto worker = borrowed->worker().value();
    const Camera camera = *borrowed->camera(8, 6);
    Model moved = std::move(*borrowed);
    std::vector<uint8_t> pixels(4 * 8 * 6);
    const Image image(pixels);
    THAT(worker.render(camera, image).ok() && moved.render(camera, image).ok());
    const Model &empty = *borrowed;
    THAT(fails(empty.info(), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(empty.camera(), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(empty.worker(), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(empty.render(camera, image), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(empty.text(PNRF_TEXT_NAME), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(empty.occupied({{0, 0, 0}}), PNRF_STATUS_NULL, "model is null"));
    THAT(empty.photograph_count() == 0 && !empty.c());
    Worker other = std::move(worker);
    THAT(other.render(camera, image).ok());
    THAT(fails(worker.render(camera, image), PNRF_STATUS_NULL, "model is null"));
    THAT(fails(worker.pick(camera, 1, 1), PNRF_STATUS_NULL, "model is null"));
#ifdef POCKETNERF_EXCEPTIONS
    try {
        Model::open("/nowhere/at all").value();
        THAT(!"thrown");
    } catch (const Error &error) {
        THAT(error.status() == PNRF_STATUS_FILE && std::strstr(error.what(), "/nowhere/at all: "));
    }
#endif
}

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    if (argc > 3) return Model::open(argv[3])->c() == nullptr;
    const Model model = *Model::open(argv[1]);
    const Model with_photographs = *Model::open(argv[2]);
    Plain plain(argv[1]);
    pictures(model, plain);
    cameras(model, with_photographs);
    questions(model, plain);
    misuse(argv[1]);
    if (!failures) std::puts("all of it as in C");
    return failures != 0;
}
