// The bare loop that tests/benchmarks/peers.py holds techniques against: Embree by itself, as one would write it in an
// afternoon. One ray through each pixel's centre, N jittered shadow rays to strata of the light, 16 pixels (4 x 4) at a
// time, all threads, tiles handed out by a counter. Nothing of Penumbra's core is in it.
//
//   penumbra_embree_loop SCENE.bin
//
// reads lines of JSON {"do": "render", "with": {"settings": {"samples": N}, "out": "FILE"}} and answers each with one:
// {"wall_ms", "cpu_ms"}. FILE, unless empty, gets two float32 images, row 0 at the bottom, 1 where nothing is seen: the
// light's unblocked share weighted by cosines and distance, and by area. The scene's format: peers/exchange.py.

#if PENUMBRA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <glm/glm.hpp>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr std::uint32_t kMagic = 0x50454552;
constexpr int kLanes = 16;
constexpr int kSide = 4;  // pixels of a packet
constexpr int kTile = 32;
constexpr float kPi = std::numbers::pi_v<float>;

enum class Kind : std::uint32_t { Rectangle, Ellipse, Sun };

struct SceneFile {
    std::uint32_t width = 0, height = 0;
    Kind kind = Kind::Rectangle;
    glm::mat4 world_from_camera{1.0F};
    float tan_half_width = 0.0F;
    glm::vec3 position{0.0F}, direction{0.0F}, half_u{0.0F}, half_v{0.0F};
    float sun_angle = 0.0F;
    std::vector<float> positions;
    std::vector<std::uint32_t> triangles;
};

template <class T>
std::vector<T> read(std::ifstream& file, std::size_t count) {
    std::vector<T> values(count);
    file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
    if (!file) {
        throw std::runtime_error("the scene file is too short");
    }
    return values;
}

SceneFile read_scene(const char* path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw std::runtime_error(std::string{"cannot open "} + path);
    }
    const auto head = read<std::uint32_t>(file, 6);
    if (head[0] != kMagic) {
        throw std::runtime_error(std::string{path} + " is no scene file");
    }
    const auto numbers = read<double>(file, 30);
    SceneFile scene;
    scene.width = head[1];
    scene.height = head[2];
    scene.kind = static_cast<Kind>(head[3]);
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            scene.world_from_camera[column][row] =
                static_cast<float>(numbers[static_cast<std::size_t>(4 * row + column)]);
        }
    }
    const auto vector = [&](std::size_t at) { return glm::vec3{numbers[at], numbers[at + 1], numbers[at + 2]}; };
    scene.tan_half_width = static_cast<float>(numbers[16]);
    scene.position = vector(17);
    scene.direction = vector(20);
    scene.half_u = vector(23);
    scene.half_v = vector(26);
    scene.sun_angle = static_cast<float>(numbers[29]);
    scene.positions = read<float>(file, std::size_t{3} * head[4]);
    scene.triangles = read<std::uint32_t>(file, std::size_t{3} * head[5]);
    return scene;
}

float random_unit(std::uint32_t& state) {
    state = state * 747796405U + 2891336453U;
    const std::uint32_t word = ((state >> ((state >> 28U) + 4U)) ^ state) * 277803737U;
    return static_cast<float>((word >> 22U) ^ word) * 0x1p-32F;
}

/// N cells of the unit square, as square as N allows.
struct Strata {
    int across, down;
    explicit Strata(int count) : across{static_cast<int>(std::sqrt(static_cast<double>(count)))}, down{1} {
        while (count % across != 0) {
            --across;
        }
        down = count / across;
    }
};

/// Concentric map of the square on the unit disc.
glm::vec2 on_disc(float a, float b) {
    const float x = 2.0F * a - 1.0F;
    const float y = 2.0F * b - 1.0F;
    if (x == 0.0F && y == 0.0F) {
        return {0.0F, 0.0F};
    }
    const bool steep = std::abs(y) > std::abs(x);
    const float radius = steep ? y : x;
    const float angle = steep ? kPi / 2.0F - kPi / 4.0F * (x / y) : kPi / 4.0F * (y / x);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

struct Images {
    std::vector<float> irradiance, area;
};

class Loop {
public:
    explicit Loop(const char* path) : file_{read_scene(path)} {
        const auto start = std::chrono::steady_clock::now();
        device_ = rtcNewDevice(nullptr);
        scene_ = rtcNewScene(device_);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        const std::size_t vertices = file_.positions.size() / 3;
        const std::size_t triangles = file_.triangles.size() / 3;
        std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices),
                    file_.positions.data(), file_.positions.size() * sizeof(float));
        std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles),
                    file_.triangles.data(), file_.triangles.size() * sizeof(std::uint32_t));
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
        build_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        float largest = 0.0F;
        for (const float x : file_.positions) {
            largest = std::max(largest, std::abs(x));
        }
        offset_ = largest * 2e-5F;
        const glm::vec3 axis = std::abs(file_.direction.z) < 0.9F ? glm::vec3{0, 0, 1} : glm::vec3{1, 0, 0};
        sun_x_ = std::tan(file_.sun_angle / 2.0F) * glm::normalize(glm::cross(file_.direction, axis));
        sun_y_ = glm::cross(file_.direction, sun_x_);
    }
    ~Loop() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    [[nodiscard]] double build_ms() const { return build_ms_; }

    void render(int samples, Images& images) const {
        const std::size_t pixels = std::size_t{file_.width} * file_.height;
        images.irradiance.resize(pixels);
        images.area.resize(pixels);
        const auto across = static_cast<int>(file_.width + kTile - 1) / kTile;
        const auto down = static_cast<int>(file_.height + kTile - 1) / kTile;
        std::atomic<int> next{0};
        const auto work = [&] {
            for (int tile = next++; tile < across * down; tile = next++) {
                for (int packet = 0; packet < kTile * kTile / kLanes; ++packet) {
                    const int x = tile % across * kTile + packet % (kTile / kSide) * kSide;
                    const int y = tile / across * kTile + packet / (kTile / kSide) * kSide;
                    if (x < static_cast<int>(file_.width) && y < static_cast<int>(file_.height)) {
                        shade(x, y, samples, images);
                    }
                }
            }
        };
        std::vector<std::jthread> threads;
        for (unsigned i = 1; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
            threads.emplace_back(work);
        }
        work();
    }

    void write(const std::string& path, const Images& images) const {
        std::ofstream out(path, std::ios::binary);
        for (const auto* image : {&images.irradiance, &images.area}) {
            out.write(reinterpret_cast<const char*>(image->data()),
                      static_cast<std::streamsize>(image->size() * sizeof(float)));
        }
    }

private:
    void shade(int x0, int y0, int samples, Images& images) const {
        alignas(64) std::array<int, kLanes> valid{};
        alignas(64) RTCRayHit16 camera{};
        const glm::vec3 eye{file_.world_from_camera[3]};
        for (int i = 0; i < kLanes; ++i) {
            const int x = x0 + i % kSide;
            const int y = y0 + i / kSide;
            valid[i] = x < static_cast<int>(file_.width) && y < static_cast<int>(file_.height) ? -1 : 0;
            const float scale = 2.0F * file_.tan_half_width / static_cast<float>(file_.width);
            const glm::vec3 local{(static_cast<float>(x) + 0.5F - 0.5F * static_cast<float>(file_.width)) * scale,
                                  (static_cast<float>(y) + 0.5F - 0.5F * static_cast<float>(file_.height)) * scale,
                                  -1.0F};
            const glm::vec3 d = glm::mat3{file_.world_from_camera} * local;
            camera.ray.org_x[i] = eye.x, camera.ray.org_y[i] = eye.y, camera.ray.org_z[i] = eye.z;
            camera.ray.dir_x[i] = d.x, camera.ray.dir_y[i] = d.y, camera.ray.dir_z[i] = d.z;
            camera.ray.tfar[i] = 1e30F;
            camera.ray.mask[i] = ~0U;
            camera.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(valid.data(), camera);

        std::array<glm::vec3, kLanes> point;
        std::array<glm::vec3, kLanes> normal;
        std::array<float, kLanes> seen{}, weight_seen{}, weight{};
        std::array<std::uint32_t, kLanes> random{};
        bool any = false;
        for (int i = 0; i < kLanes; ++i) {
            if (valid[i] != 0 && camera.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
                valid[i] = 0;
                store(images, x0, y0, i, 1.0F, 1.0F);
            }
            const glm::vec3 d{camera.ray.dir_x[i], camera.ray.dir_y[i], camera.ray.dir_z[i]};
            glm::vec3 n = glm::normalize(glm::vec3{camera.hit.Ng_x[i], camera.hit.Ng_y[i], camera.hit.Ng_z[i]});
            n = glm::dot(n, d) > 0.0F ? -n : n;
            normal[i] = n;
            point[i] = eye + camera.ray.tfar[i] * d + offset_ * n;
            random[i] = static_cast<std::uint32_t>((y0 + i / kSide) * 65536 + x0 + i % kSide) * 2654435761U;
            any = any || valid[i] != 0;
        }
        if (!any) {
            return;
        }
        const Strata strata{samples};
        for (int k = 0; k < samples; ++k) {
            alignas(64) RTCRay16 ray{};
            std::array<float, kLanes> w{};
            for (int i = 0; i < kLanes; ++i) {
                const float a = (static_cast<float>(k % strata.across) + random_unit(random[i])) /
                                static_cast<float>(strata.across);
                const float b =
                    (static_cast<float>(k / strata.across) + random_unit(random[i])) / static_cast<float>(strata.down);
                glm::vec3 to;
                if (file_.kind == Kind::Sun) {
                    const glm::vec2 at = on_disc(a, b);
                    to = at.x * sun_x_ + at.y * sun_y_ - file_.direction;
                    w[i] = std::max(0.0F, glm::dot(normal[i], to));
                    ray.tfar[i] = 1e30F;
                } else {
                    const glm::vec2 at =
                        file_.kind == Kind::Ellipse ? on_disc(a, b) : glm::vec2{2.0F * a - 1.0F, 2.0F * b - 1.0F};
                    to = file_.position + at.x * file_.half_u + at.y * file_.half_v - point[i];
                    const float square = glm::dot(to, to);
                    w[i] = std::max(0.0F, glm::dot(normal[i], to)) * std::max(0.0F, -glm::dot(file_.direction, to)) /
                           (square * square);
                    ray.tfar[i] = 0.9999F;
                }
                ray.org_x[i] = point[i].x, ray.org_y[i] = point[i].y, ray.org_z[i] = point[i].z;
                ray.dir_x[i] = to.x, ray.dir_y[i] = to.y, ray.dir_z[i] = to.z;
                ray.mask[i] = ~0U;
            }
            occluded(valid.data(), ray);
            for (int i = 0; i < kLanes; ++i) {
                const bool free = ray.tfar[i] >= 0.0F;
                seen[i] += free ? 1.0F : 0.0F;
                weight_seen[i] += free ? w[i] : 0.0F;
                weight[i] += w[i];
            }
        }
        for (int i = 0; i < kLanes; ++i) {
            if (valid[i] != 0) {
                store(images, x0, y0, i, weight[i] > 0.0F ? weight_seen[i] / weight[i] : 1.0F,
                      seen[i] / static_cast<float>(samples));
            }
        }
    }

    void store(Images& images, int x0, int y0, int lane, float irradiance, float area) const {
        const std::size_t at =
            static_cast<std::size_t>(y0 + lane / kSide) * file_.width + static_cast<std::size_t>(x0 + lane % kSide);
        images.irradiance[at] = irradiance;
        images.area[at] = area;
    }

#if PENUMBRA_EMBREE_MAJOR >= 4
    void intersect(const int* valid, RTCRayHit16& rays) const {
        RTCIntersectArguments arguments;
        rtcInitIntersectArguments(&arguments);
        arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
        rtcIntersect16(valid, scene_, &rays, &arguments);
    }
    void occluded(const int* valid, RTCRay16& rays) const {
        RTCOccludedArguments arguments;
        rtcInitOccludedArguments(&arguments);
        arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
        rtcOccluded16(valid, scene_, &rays, &arguments);
    }
#else
    void intersect(const int* valid, RTCRayHit16& rays) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect16(valid, scene_, &context, &rays);
    }
    void occluded(const int* valid, RTCRay16& rays) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcOccluded16(valid, scene_, &context, &rays);
    }
#endif

    SceneFile file_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    double build_ms_ = 0.0;
    float offset_ = 0.0F;
    glm::vec3 sun_x_{0.0F}, sun_y_{0.0F};
};

double cpu_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// The text after "key": in a line of JSON that peers/worker.py wrote, up to a comma, a brace or the closing quote.
std::string value_of(const std::string& line, const std::string& key) {
    const std::size_t at = line.find("\"" + key + "\": ");
    if (at == std::string::npos) {
        throw std::runtime_error("the request has no " + key);
    }
    std::size_t begin = at + key.size() + 4;
    const bool quoted = line[begin] == '"';
    begin += quoted ? 1 : 0;
    return line.substr(begin, line.find_first_of(quoted ? "\"" : ",}", begin) - begin);
}

}  // namespace

int main(int count, char** arguments) {
    try {
        if (count != 2) {
            throw std::runtime_error("usage: penumbra_embree_loop SCENE.bin");
        }
        const Loop loop{arguments[1]};
        std::cout << "{\"sync_ms\": " << loop.build_ms() << ", \"version\": \"" << RTC_VERSION_STRING << "\"}"
                  << std::endl;
        Images images;
        for (std::string line; std::getline(std::cin, line);) {
            const int samples = std::stoi(value_of(line, "samples"));
            if (samples < 1) {
                throw std::runtime_error("samples is at least 1");
            }
            const double cpu = cpu_ms();
            const auto start = std::chrono::steady_clock::now();
            loop.render(samples, images);
            const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
            const double busy = cpu_ms() - cpu;
            if (const std::string out = value_of(line, "out"); !out.empty()) {
                loop.write(out, images);
            }
            std::cout << "{\"wall_ms\": " << wall.count() << ", \"cpu_ms\": " << busy << "}" << std::endl;
        }
        return 0;
    } catch (const std::exception& error) {
        std::cout << "{\"error\": \"" << error.what() << "\"}" << std::endl;
        return 1;
    }
}
