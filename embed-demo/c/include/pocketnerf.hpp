// pocketnerf for C++17: radiance fields from .pnerf files, on the CPU. Header only, over pocketnerf.h.
//
//     auto model = pocketnerf::Model::open("scene.pnerf");
//     if (!model) return fail(model.error().what());
//     auto camera = model->camera(800, 600);
//
// Calls that can fail return a Result: a value, or an Error with its one line. There are two ways to
// read it. Ask `if (result)` first, then `*result` or `result.error()`: nothing throws, and programs
// without exceptions and RTTI can do so. Or define POCKETNERF_EXCEPTIONS and write `.value()`, which
// throws the Error. Without that macro, taking the value of a failure prints the line and aborts.
//
// A Model never changes and may be used by any number of threads. A Worker has the memory that
// rendering and queries need: one for each thread. It keeps its model open.
#ifndef POCKETNERF_HPP
#define POCKETNERF_HPP

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pocketnerf.h"

namespace pocketnerf {

// Files that are compiled with the macro and without it may be linked together.
#ifdef POCKETNERF_EXCEPTIONS
inline namespace throwing {
#else
inline namespace aborting {
#endif

using Camera = PnrfCamera;
using Hit = PnrfHit;
using Info = PnrfInfo;
using Stats = PnrfStats;
using Tile = PnrfTile;

/// A point, a direction or a colour.
using Vec3 = std::array<float, 3>;

struct Ray {
    Vec3 origin, direction;
};
struct Segment {
    Vec3 from, to;
};
struct Ball {
    Vec3 center;
    float radius;
};
struct Radiance {
    Vec3 rgb;
    float sigma;
};
static_assert(sizeof(Ray) == 24 && sizeof(Segment) == 24 && sizeof(Ball) == 16 &&
              sizeof(Radiance) == 16, "lists go to C as they are");

/// What went wrong: a code, and one line about what was found and what was expected.
class Error : public std::exception {
public:
    explicit Error(const PnrfError &error) : error_(error) {}
    Error(PnrfStatus status, const std::string &line) : error_{status, {}} {
        line.copy(error_.text, sizeof error_.text - 1);
    }
    PnrfStatus status() const noexcept { return error_.status; }
    const char *what() const noexcept override { return error_.text; }

private:
    PnrfError error_;
};

namespace detail {
[[noreturn]] inline void fail(const Error &error) {
#ifdef POCKETNERF_EXCEPTIONS
    throw error;
#else
    std::fprintf(stderr, "pocketnerf: %s\n", error.what());
    std::abort();
#endif
}
}  // namespace detail

/// A value or an Error.
template <class T> class [[nodiscard]] Result {
public:
    Result(T value) : value_(std::move(value)) {}
    Result(Error error) : error_(std::move(error)) {}

    bool ok() const noexcept { return value_.has_value(); }
    explicit operator bool() const noexcept { return ok(); }
    /// Why there is no value; null if there is one.
    const Error *failure() const noexcept { return error_ ? &*error_ : nullptr; }
    /// The same; of a success, an Error with PNRF_STATUS_OK and an empty line.
    Error error() const { return error_ ? *error_ : Error(PNRF_STATUS_OK, ""); }

    /// The value. Of a failure it throws the Error, or prints its line and aborts: see above.
    T &value() & { return checked(*this); }
    const T &value() const & { return checked(*this); }
    T value() && { return std::move(checked(*this)); }
    T &operator*() & { return value(); }
    const T &operator*() const & { return value(); }
    T operator*() && { return std::move(*this).value(); }
    T *operator->() { return &value(); }
    const T *operator->() const { return &value(); }

private:
    template <class Self> static auto &checked(Self &self) {
        if (!self.value_) detail::fail(*self.error_);
        return *self.value_;
    }
    std::optional<T> value_;
    std::optional<Error> error_;
};

/// How pictures and queries are computed.
struct Options {
    PnrfSimd simd = PNRF_SIMD_DETECT;
    PnrfSampling sampling = PNRF_SAMPLING_OCCUPANCY;
    PnrfMemory memory = PNRF_MEMORY_FAST;
    /// From 0, the fastest, to 1, the finest; below 0: as the file says, usually 0.5.
    float quality = -1;

    PnrfOptions c() const {
        return {static_cast<uint32_t>(simd), static_cast<uint32_t>(sampling),
                static_cast<uint32_t>(memory), quality};
    }
};

/// Where a whole picture goes: memory of the caller's, which stays in place while it is rendered.
/// Rows from top to bottom; all that PnrfImage has may be set: strides, bottom_up, BGRA.
struct Image : PnrfImage {
    Image() : PnrfImage{} {}
    /// Four bytes a pixel: red, green, blue, alpha.
    explicit Image(std::vector<uint8_t> &rgba) : Image() {
        pixels = rgba.data();
        size = rgba.size();
    }
    /// Four numbers a pixel, in the model's own colour space.
    explicit Image(std::vector<float> &rgba) : Image() {
        pixels = rgba.data();
        size = rgba.size() * sizeof(float);
        format = static_cast<uint32_t>(PNRF_FORMAT_RGBA_F32);
    }
    /// Over this colour, 0 to 1, in the model's own colour space; without it, black.
    Image &over(const float (&rgb)[3]) {
        std::copy_n(rgb, 3, background);
        alpha = static_cast<uint32_t>(PNRF_ALPHA_BACKGROUND);
        return *this;
    }
    Image &with_alpha(PnrfAlpha how) {
        alpha = static_cast<uint32_t>(how);
        return *this;
    }
    /// Depth too, one number a pixel.
    Image &with_depth(std::vector<float> &depths, PnrfDepthKind kind = PNRF_DEPTH_KIND_DISTANCE) {
        depth = depths.data();
        depth_size = depths.size() * sizeof(float);
        depth_kind = static_cast<uint32_t>(kind);
        return *this;
    }
};

namespace detail {
/// `made` if `call`, which is given the place of an error, succeeds.
template <class T, class Call> Result<T> got(T made, Call call) {
    PnrfError error{};
    if (call(made, &error) != PNRF_STATUS_OK) return Error(error);
    return Result<T>(std::move(made));
}
template <class T> const float *numbers(const std::vector<T> &list) {
    return reinterpret_cast<const float *>(list.data());
}
template <class T> float *numbers(std::vector<T> &list) {
    return reinterpret_cast<float *>(list.data());
}
using Shared = std::shared_ptr<const PnrfModel>;
}  // namespace detail

/// What one thread renders and asks with: memory, and options. It keeps the model open.
class Worker {
public:
    Worker(Worker &&) = default;
    Worker &operator=(Worker &&) = default;

    /// Renders a picture on this thread.
    Result<Stats> render(const Camera &camera, const Image &image) {
        return detail::got(Stats{}, [&](Stats &stats, PnrfError *error) {
            return pnrf_render(model_.get(), &camera, &options_, &image, memory(), length(), &stats,
                               error);
        });
    }
    /// Renders one tile of it, `number` from 0 to tile_count() - 1, into its place in the image.
    Result<Stats> render_tile(const Camera &camera, uint32_t number, const Image &image) {
        return detail::got(Stats{}, [&](Stats &stats, PnrfError *error) {
            return pnrf_render_tile(model_.get(), &camera, &options_, number, &image, memory(),
                                    length(), &stats, error);
        });
    }
    uint32_t tile_count(const Camera &camera) const {
        return pnrf_tile_count(camera.width, camera.height, &options_);
    }
    /// The rectangle that a tile covers.
    Result<Tile> tile(const Camera &camera, uint32_t number) const {
        return detail::got(Tile{}, [&](Tile &tile, PnrfError *error) {
            return pnrf_tile(camera.width, camera.height, &options_, number, &tile, error);
        });
    }

    /// What is under a pixel; its depth is infinite where there is nothing.
    Result<Hit> pick(const Camera &camera, float x, float y) {
        auto hits = pick(camera, {{x, y}});
        if (!hits) return hits.error();
        return hits->front();
    }
    Result<std::vector<Hit>> pick(const Camera &camera,
                                  const std::vector<std::array<float, 2>> &pixels) {
        const size_t n = pixels.size();
        return detail::got(std::vector<Hit>(n), [&](std::vector<Hit> &hits, PnrfError *error) {
            return pnrf_pick(model_.get(), &options_, &camera, detail::numbers(pixels), n,
                             hits.data(), memory(), length(), error);
        });
    }
    /// How far the rays see, infinite where they see nothing of the kind; along `axis`, such as a
    /// camera's, if it is given.
    Result<std::vector<float>> depths(const std::vector<Ray> &rays,
                                      PnrfDepth kind = PNRF_DEPTH_MEDIAN, float threshold = 0,
                                      const Vec3 *axis = nullptr) {
        return ask<float>(rays, [&](const float *in, size_t n, float *out, PnrfError *error) {
            return pnrf_depths(model_.get(), &options_, in, n, static_cast<uint32_t>(kind),
                               threshold, axis ? axis->data() : nullptr, out, memory(), length(),
                               error);
        });
    }
    /// Sigma: the fraction of light absorbed per length.
    Result<std::vector<float>> density(const std::vector<Vec3> &points) {
        return about<float>(points, pnrf_density);
    }
    /// Colours of points seen along directions, as many as points; and sigma.
    Result<std::vector<Radiance>> radiance(const std::vector<Vec3> &points,
                                           const std::vector<Vec3> &directions) {
        if (points.size() != directions.size())
            return Error(PNRF_STATUS_ARGUMENT, std::to_string(directions.size()) +
                                                   " directions, expected one for each of " +
                                                   std::to_string(points.size()) + " points");
        return ask<Radiance>(points, [&](const float *at, size_t n, float *out, PnrfError *error) {
            return pnrf_radiance(model_.get(), &options_, at, detail::numbers(directions), n, out,
                                 memory(), length(), error);
        });
    }
    Result<std::vector<Vec3>> density_gradient(const std::vector<Vec3> &points) {
        return about<Vec3>(points, pnrf_density_gradient);
    }
    /// Where surfaces face; zero where sigma has no gradient.
    Result<std::vector<Vec3>> normals(const std::vector<Vec3> &points) {
        return about<Vec3>(points, pnrf_normals);
    }
    /// The light that passes between two points.
    Result<std::vector<float>> transmittance(const std::vector<Segment> &segments) {
        return about<float>(segments, pnrf_segment_transmittance);
    }
    /// Of a body that these points fill: see pnrf_collision_probability.
    Result<float> collision_probability(const std::vector<Vec3> &points, float volume,
                                        float particle_area) {
        return detail::got(0.0f, [&](float &probability, PnrfError *error) {
            return pnrf_collision_probability(model_.get(), &options_, detail::numbers(points),
                                              points.size(), volume, particle_area, &probability,
                                              memory(), length(), error);
        });
    }

private:
    friend class Model;
    Worker(detail::Shared model, const PnrfOptions &options, size_t length)
        : model_(std::move(model)), options_(options), scratch_(length) {}

    template <class Answer, class Question, class Call>
    Result<std::vector<Answer>> ask(const std::vector<Question> &questions, Call call) {
        const size_t n = questions.size();
        return detail::got(std::vector<Answer>(n), [&](std::vector<Answer> &out, PnrfError *error) {
            return call(detail::numbers(questions), n, detail::numbers(out), error);
        });
    }
    template <class Answer, class Question, class Call>
    Result<std::vector<Answer>> about(const std::vector<Question> &questions, Call function) {
        return ask<Answer>(questions, [&](const float *in, size_t n, float *out, PnrfError *error) {
            return function(model_.get(), &options_, in, n, out, memory(), length(), error);
        });
    }
    float *memory() { return scratch_.data(); }
    size_t length() const { return scratch_.size(); }

    detail::Shared model_;
    PnrfOptions options_;
    std::vector<float> scratch_;
};

/// An open model. One that was moved from is closed: its calls fail.
class Model {
public:
    Model(Model &&) = default;
    Model &operator=(Model &&) = default;

    /// Opens a file. `flags` are PNRF_OPEN_UNVERIFIED and so on, or 0.
    static Result<Model> open(const std::string &path, uint32_t flags = 0) {
        return opened([&](PnrfModel **model, PnrfError *error) {
            return pnrf_open_file(path.c_str(), flags, model, error);
        });
    }
    /// Opens a model in memory, which is copied.
    static Result<Model> from_bytes(const void *bytes, size_t length, uint32_t flags = 0) {
        return opened([&](PnrfModel **model, PnrfError *error) {
            return pnrf_open_bytes(bytes, length, flags, model, error);
        });
    }
    /// The same without a copy: the bytes stay in place, unchanged, as long as the model and its
    /// workers.
    static Result<Model> borrow(const void *bytes, size_t length, uint32_t flags = 0) {
        return from_bytes(bytes, length, flags | PNRF_OPEN_BORROWED);
    }

    Result<Info> info() const {
        return detail::got(Info{}, [&](Info &info, PnrfError *error) {
            return pnrf_info(model_.get(), &info, error);
        });
    }
    /// A fact in words; empty if the file does not say.
    Result<std::string> text(PnrfText which) const {
        size_t length = 0;
        const auto code = static_cast<uint32_t>(which);
        (void)pnrf_text(model_.get(), code, nullptr, 0, &length, nullptr);
        auto text = detail::got(std::string(length, 0), [&](std::string &to, PnrfError *error) {
            return pnrf_text(model_.get(), code, to.data(), length, nullptr, error);
        });
        // The final zero.
        if (text) text->pop_back();
        return text;
    }

    /// The file's own view, or one beside the scene; 0x0: of the file's own size.
    Result<Camera> camera(uint32_t width = 0, uint32_t height = 0) const {
        return detail::got(Camera{}, [&](Camera &camera, PnrfError *error) {
            return pnrf_default_camera(model_.get(), width, height, &camera, error);
        });
    }
    /// A camera that goes around the centre: angles in radians; distance 0: as far away as the
    /// file's own; about what is up.
    Result<Camera> orbit(float azimuth, float elevation, float distance = 0) const {
        return detail::got(Camera{}, [&](Camera &camera, PnrfError *error) {
            return pnrf_orbit_camera(model_.get(), azimuth, elevation, distance, nullptr, 0, 0,
                                     &camera, error);
        });
    }
    /// About another direction, with a picture of another size.
    Result<Camera> orbit(float azimuth, float elevation, float distance, const Vec3 &up,
                         uint32_t width = 0, uint32_t height = 0) const {
        return detail::got(Camera{}, [&](Camera &camera, PnrfError *error) {
            return pnrf_orbit_camera(model_.get(), azimuth, elevation, distance, up.data(), width,
                                     height, &camera, error);
        });
    }
    /// What is up, a unit vector: z where the file says nothing.
    Result<Vec3> up() const {
        return detail::got(Vec3{}, [&](Vec3 &up, PnrfError *error) {
            return pnrf_world(model_.get(), up.data(), nullptr, error);
        });
    }
    /// How long the unit of coordinates is; 0 where the file says nothing.
    Result<float> metres_per_unit() const {
        return detail::got(0.0f, [&](float &metres, PnrfError *error) {
            return pnrf_world(model_.get(), nullptr, &metres, error);
        });
    }
    /// How many photographs' cameras the file has.
    uint32_t photograph_count() const { return pnrf_photograph_count(model_.get()); }
    Result<Camera> photograph(uint32_t number, uint32_t width = 0, uint32_t height = 0) const {
        return detail::got(Camera{}, [&](Camera &camera, PnrfError *error) {
            return pnrf_photograph_camera(model_.get(), number, width, height, &camera, error);
        });
    }

    /// What a thread needs to render and to ask.
    Result<Worker> worker(const Options &options = {}) const {
        const PnrfOptions c = options.c();
        auto length = detail::got(size_t{0}, [&](size_t &needed, PnrfError *error) {
            return pnrf_scratch_length(model_.get(), &c, &needed, error);
        });
        if (!length) return length.error();
        return Worker(model_, c, *length);
    }

    /// Renders a picture on so many threads, the caller's among them; 0: on all cores. The bytes
    /// do not depend on their number.
    Result<Stats> render(const Camera &camera, const Image &image, const Options &options = {},
                         unsigned threads = 0) const {
        auto first = worker(options);
        if (!first) return first.error();
        // A camera without tiles is refused by the first call.
        const uint32_t n_tiles = std::max(first->tile_count(camera), 1u);
        if (threads == 0) threads = std::max(std::thread::hardware_concurrency(), 1u);
        std::vector<Worker> workers;
        workers.push_back(std::move(*first));
        while (workers.size() < std::min(threads, n_tiles))
            workers.push_back(Worker(model_, workers[0].options_, workers[0].length()));

        std::atomic<uint32_t> next{0};
        std::vector<Result<Stats>> took(workers.size(), Stats{});
        const auto work = [&](size_t which) {
            for (uint32_t number; (number = next++) < n_tiles;) {
                auto tile = workers[which].render_tile(camera, number, image);
                if (!tile) {
                    next = n_tiles;
                    took[which] = tile;
                    return;
                }
                add(*took[which], *tile);
            }
        };
        {
            Threads others;
            for (size_t i = 1; i < workers.size(); i++) others.list.emplace_back(work, i);
            work(0);
        }
        Stats sum{};
        for (auto &one : took) {
            if (!one) return one;
            add(sum, *one);
        }
        return sum;
    }

    /// Whether `n` points lie in occupied cells: 0 or 1 each.
    Result<std::vector<uint8_t>> occupied(const std::vector<Vec3> &points) const {
        return whether(points, pnrf_occupied);
    }
    /// Whether balls are certainly free: 0 or 1 each.
    Result<std::vector<uint8_t>> clear(const std::vector<Ball> &balls) const {
        return whether(balls, pnrf_sphere_clear);
    }

    /// For calls of pocketnerf.h; null if the model was moved from.
    const PnrfModel *c() const noexcept { return model_.get(); }

private:
    /// Joins, whatever happens.
    struct Threads {
        std::vector<std::thread> list;
        ~Threads() {
            for (auto &thread : list) thread.join();
        }
    };

    explicit Model(PnrfModel *model) : model_(model, [](auto *open) { pnrf_close(open); }) {}

    template <class Call> static Result<Model> opened(Call call) {
        const uint32_t ours = PNRF_ABI_VERSION, linked = pnrf_abi_version();
        if (linked >> 16 != ours >> 16 || linked < ours)
            return Error(PNRF_STATUS_VERSION, "the library has interface " + version(linked) +
                                                  ", expected " + version(ours) + " or later");
        PnrfModel *model = nullptr;
        PnrfError error{};
        if (call(&model, &error) != PNRF_STATUS_OK) return Error(error);
        return Model(model);
    }
    static std::string version(uint32_t abi) {
        return std::to_string(abi >> 16) + "." + std::to_string(abi & 0xffff);
    }
    static void add(Stats &sum, const Stats &more) {
        sum.rays += more.rays;
        sum.samples += more.samples;
        sum.hits += more.hits;
    }
    template <class Question, class Call>
    Result<std::vector<uint8_t>> whether(const std::vector<Question> &list, Call call) const {
        using Flags = std::vector<uint8_t>;
        return detail::got(Flags(list.size()), [&](Flags &out, PnrfError *error) {
            return call(model_.get(), detail::numbers(list), list.size(), out.data(), error);
        });
    }

    // Moving leaves it empty, which the library refuses in a line.
    std::shared_ptr<PnrfModel> model_;
};

/// A camera at `eye` that looks at `target`; `fov_x` is its horizontal field of view, radians.
inline Result<Camera> look_at(const Vec3 &eye, const Vec3 &target, const Vec3 &up, float fov_x,
                              uint32_t width, uint32_t height) {
    return detail::got(Camera{}, [&](Camera &camera, PnrfError *error) {
        return pnrf_look_at(eye.data(), target.data(), up.data(), fov_x, width, height, &camera,
                            error);
    });
}

/// A camera with this 4x4 camera-to-world matrix, row after row: columns are right, up, back and
/// its position. Checked when it is used.
inline Camera camera_from(const std::array<float, 16> &camera_to_world, float focal,
                          uint32_t width, uint32_t height) {
    const auto half = [](uint32_t side) { return 0.5f * static_cast<float>(side); };
    Camera camera{width, height, {focal, focal}, {half(width), half(height)}, {}};
    std::copy(camera_to_world.begin(), camera_to_world.end(), camera.camera_to_world);
    return camera;
}

}  // namespace (throwing or aborting)
}  // namespace pocketnerf

#endif  // POCKETNERF_HPP
