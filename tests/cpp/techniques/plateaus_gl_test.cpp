// Plateaus against their closed forms: plateaus.md section 3, through the whole renderer.
#include <cstdio>

#include <random>

#include "geometry/plateau.h"
#include "geometry/silhouettes.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

using scenes::kPi;

Settings with(Settings settings, const std::string& id, const char* value) {
    settings[id] = std::string{value};
    return settings;
}

class PlateausGl : public RendererGl {
protected:
    /// RMSE over 1e-4 < truth < 1 - 1e-4, along a straight_edge() image.
    double penumbra_rmse(const Scene& scene, const Settings& settings, const std::function<double(double)>& truth) {
        const std::vector<double> v = profile(visibility(scene, "plateaus", settings), scene.camera);
        double sum = 0.0;
        int count = 0;
        for (std::size_t x = 0; x < v.size(); ++x) {
            const double t = truth(scenes::column_x(scene.camera, static_cast<int>(x)));
            if (t > 1e-4 && t < 1.0 - 1e-4) {
                sum += (v[x] - t) * (v[x] - t);
                ++count;
            }
        }
        return std::sqrt(sum / std::max(count, 1));
    }
    std::vector<BakedTexture> bake(const Scene& scene, const Settings& settings) {
        renderer().set_scene(scene);
        return renderer().bake(0, {"plateaus", settings}, control_);
    }
    bool rule_fires(const Scene& scene, const std::string& rule, bool keep_everything = false) {
        renderer().set_scene(scene);
        const Plan plan = renderer().visibility(0, {"plateaus", {}}, keep_everything, control_).plan;
        return std::any_of(plan.steps.begin(), plan.steps.end(), [&](const Step& step) { return step.rule == rule; });
    }
    static void dump(const std::vector<float>& v, const Camera& camera, const std::string& name) {
        if (const char* folder = std::getenv("PLATEAUS_DUMP")) {
            std::FILE* file = std::fopen((std::string{folder} + "/" + name + ".pgm").c_str(), "wb");
            std::fprintf(file, "P5 %d %d 255\n", camera.width_px, camera.height_px);
            for (int y = camera.height_px - 1; y >= 0; --y) {
                for (int x = 0; x < camera.width_px; ++x) {
                    std::fputc(static_cast<int>(255.0F * v[static_cast<std::size_t>(y * camera.width_px + x)]), file);
                }
            }
            std::fclose(file);
        }
    }
};

Light disc_light(const glm::dvec3& centre, double radius) {
    Light light = scenes::rectangle_light(centre, 2.0 * radius, 2.0 * radius);
    light.kind = LightKind::Ellipse;
    return light;
}

Light triangle_light(const glm::dvec3& centre, double size) {
    Light light = scenes::rectangle_light(centre, size, size);
    light.kind = LightKind::Polygon;
    light.corners_ws = {centre + size * glm::dvec3{0.7, 0.5, 0.0}, centre + size * glm::dvec3{0.1, -1.0, 0.0},
                        centre + size * glm::dvec3{-0.8, 0.5, 0.0}};
    light.half_u_ws = light.half_v_ws = glm::dvec3{0.0};
    return light;
}

Scene picture_scene(const Light& light) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(24, false), "ball", {0.6, 0.5, 1.2}));
    const auto bar = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(scenes::place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
    }
    scene.instances.push_back(
        scenes::place(scenes::box({-0.4F, -0.3F, 1.0F}, {0.4F, 0.3F, 1.1F}), "slab", {-1.4, 1.0, 0.3}));
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(3.0, 480, 360, 20.0);
    const double a = 0.6;
    const glm::dmat3 tilt{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    scene.camera.world_from_camera = glm::dmat4{tilt};
    scene.camera.world_from_camera[3] = glm::dvec4{tilt * glm::dvec3{0, 0, 20}, 1.0};
    return scene;
}

TEST_F(PlateausGl, DISABLED_Pictures) {
    const std::vector<std::pair<std::string, Light>> lights{
        {"disc", disc_light({0.8, -0.6, 4.0}, 0.4)},
        {"rect", scenes::rectangle_light({0.8, -0.6, 4.0}, 0.8, 0.4)},
        {"ball", scenes::point_light({0.8, -0.6, 4.0}, 0.4)},
        {"sun", scenes::sun_light({1.0, 0.3, -0.6}, 0.2)},
    };
    for (const auto& [name, light] : lights) {
        const Scene scene = picture_scene(light);
        renderer().set_scene(scene);
        const Reference truth = renderer().reference(0, {.standard_error = 0.02}, control_);
        dump(truth.area, scene.camera, name + "_truth");
        for (const char* sheets : {"envelope", "bilinear", "tess"}) {
            dump(visibility(scene, "plateaus", with({}, "sheet_mode", sheets)), scene.camera, name + "_" + sheets);
        }
        dump(visibility(scene, "plateaus", with({}, "sides", "both")), scene.camera, name + "_both");
        dump(visibility(scene, "plateaus", with({}, "edges", "all")), scene.camera, name + "_all");
        const auto fan = with(with({}, "sheet_mode", "bilinear"), "cones", "fan");
        dump(visibility(scene, "plateaus", fan), scene.camera, name + "_fan");
    }
}

/// World position of a texel's centre.
glm::dvec3 texel_ws(const BakedTexture& texture, int x, int y) {
    const double u = (x + 0.5) / texture.width_px, v = (y + 0.5) / texture.height_px;
    return texture.corners_ws[0] + u * (texture.corners_ws[1] - texture.corners_ws[0]) +
           v * (texture.corners_ws[3] - texture.corners_ws[0]);
}
float at(const BakedTexture& texture, int x, int y) {
    return texture.visibility[static_cast<std::size_t>(y) * texture.width_px + x];
}
/// True if a texel and its neighbours are on one side of the hard shadow's edge.
bool clear_of_umbra(const BakedTexture& texture, int x, int y) {
    for (int j = std::max(0, y - 1); j <= std::min(texture.height_px - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(texture.width_px - 1, x + 1); ++i) {
            if (at(texture, i, j) <= 0.0F) {
                return false;
            }
        }
    }
    return true;
}

std::shared_ptr<Mesh> tetrahedron(std::mt19937& random, double size) {
    std::uniform_real_distribution<float> u{-static_cast<float>(size), static_cast<float>(size)};
    std::vector<glm::vec3> p;
    for (int i = 0; i < 4; ++i) {
        p.emplace_back(u(random), u(random), u(random));
    }
    if (glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) > 0.0F) {
        std::swap(p[1], p[2]);
    }
    return scenes::mesh("tetrahedron", p, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
}

/// A prism over a five-pointed star: corners that are convex and corners that are not.
std::shared_ptr<Mesh> star(double height) {
    auto made = std::make_shared<Mesh>();
    made->name = "star";
    for (unsigned top = 0; top < 2; ++top) {
        made->positions_local.emplace_back(0.0F, 0.0F, top * height);
        for (unsigned i = 0; i < 10; ++i) {
            const double radius = i % 2 == 0 ? 0.9 : 0.35, angle = kPi * i / 5.0 + 0.2;
            made->positions_local.emplace_back(radius * std::cos(angle), radius * std::sin(angle), top * height);
        }
    }
    for (unsigned i = 0; i < 10; ++i) {
        const unsigned a = 1 + i, b = 1 + (i + 1) % 10;
        made->triangles.emplace_back(0, b, a);
        made->triangles.emplace_back(11, 11 + a, 11 + b);
        made->triangles.emplace_back(a, b, 11 + b);
        made->triangles.emplace_back(a, 11 + b, 11 + a);
    }
    return made;
}

/// A floor and casters that the camera does not see, from above.
Scene over_floor(const Light& light, const std::vector<Instance>& casters, double half_m = 2.0, int size_px = 96) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-30, 30, -30, 30), "floor"));
    for (Instance caster : casters) {
        caster.visible = false;
        scene.instances.push_back(caster);
    }
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(half_m, size_px, size_px);
    return scene;
}

/// Edges of an instance in world space: all, or those that are silhouettes of the light's centre.
std::vector<std::pair<glm::dvec3, glm::dvec3>> edges_of(const Instance& instance, const Light& light,
                                                        bool silhouettes) {
    const Adjacency adjacency = make_adjacency(*instance.mesh);
    const glm::dmat4 local_from_world = glm::inverse(instance.world_from_local);
    const glm::dvec4 centre =
        light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0};
    std::vector<std::pair<glm::dvec3, glm::dvec3>> edges;
    const auto place = [&](std::uint32_t v) {
        return glm::dvec3{instance.world_from_local * glm::dvec4{instance.mesh->positions_local[v], 1.0}};
    };
    for (const SilhouetteEdge& edge : find_silhouettes(*instance.mesh, adjacency, local_from_world * centre, false,
                                                       silhouettes ? EdgeChoice::Silhouettes : EdgeChoice::All)) {
        edges.emplace_back(place(edge.a), place(edge.b));
    }
    return edges;
}

/// E1, independent of cones and sheets: the edge is carried from p to the light's own plane, and its distance from the
/// light's centre is measured there in the light's gauge.
double back_projected(const glm::dvec3& p, const std::pair<glm::dvec3, glm::dvec3>& edge, const Light& light) {
    glm::dvec3 u = light.half_u_ws, v = light.half_v_ws, centre = light.position_ws;
    plateau::RoundedBox shape =
        light.kind == LightKind::Rectangle ? plateau::RoundedBox{{1, 1}, 0.0} : plateau::RoundedBox{};
    std::vector<glm::dvec2> corners;
    if (light.kind == LightKind::Polygon) {
        u = {1, 0, 0};
        v = {0, 1, 0};
        for (const glm::dvec3& c : light.corners_ws) {
            corners.insert(corners.begin(), glm::dvec2{c - centre});  // clockwise from above: turned round
        }
    }
    glm::dvec3 m = glm::cross(u, v);
    if (light.kind == LightKind::Point) {  // the disc in which the tangent cone meets the plane across the sight
        const double distance = glm::length(centre - p);
        m = (centre - p) / distance;
        const double radius = light.radius_m / std::sqrt(1.0 - std::pow(light.radius_m / distance, 2));
        u = radius * glm::normalize(glm::cross(m, glm::dvec3{0.3, 0.8, 0.1}));
        v = glm::cross(m, u);
    } else if (light.kind == LightKind::Sun) {  // directions: a disc at the distance 1
        m = -light.direction_ws;
        centre = p + m;
        u = std::tan(0.5 * light.sun_angle_rad) * glm::normalize(glm::cross(m, glm::dvec3{0.3, 0.8, 0.1}));
        v = glm::cross(m, u);
    }
    const double side = glm::dot(centre - p, m);
    const auto carried = [&](const glm::dvec3& a) {  // homogeneous: the edge may reach behind p
        const double depth = glm::dot(a - p, m) / side;
        const glm::dvec3 offset = a - p - depth * (centre - p);
        return glm::dvec3{glm::dot(offset, u) / glm::dot(u, u), glm::dot(offset, v) / glm::dot(v, v), depth};
    };
    return corners.empty() ? plateau::gauge(shape, carried(edge.first), carried(edge.second))
                           : plateau::gauge(corners, carried(edge.first), carried(edge.second));
}

// Published: nothing inside the hard edge, so the error of a step against a ramp, 1/sqrt(12).
TEST_F(PlateausGl, OnTheStraightEdgeTheOuterFormHasTheErrorOfAHardShadow) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 1024);
    const double w = 0.5 / 3.0;
    const auto truth = [&](double x) { return std::clamp(0.5 + 0.5 * x / w, 0.0, 1.0); };
    EXPECT_NEAR(penumbra_rmse(scene, {}, truth), 0.289, 0.01);
    EXPECT_LE(penumbra_rmse(scene, with({}, "sides", "both"), truth), 0.01);
}

// B1: never lighter than the truth with linear falloff; over the outer half 1/2 against 1 - 2/(3 pi).
TEST_F(PlateausGl, OnTheStraightEdgeOfADiscErrorsAreThoseOfTheClosedForm) {
    const Scene scene = scenes::straight_edge(disc_light({0, 0, 4}, 0.5), 1.0, 0.0, 1024);
    const double w = 0.5 / 3.0;
    const auto truth = [&](double x) { return plateau::disc_cut(x / w); };
    EXPECT_LE(penumbra_rmse(scene, with({}, "sides", "both"), truth), 0.01);
    for (const char* falloff : {"linear", "sine", "smoothstep", "disc"}) {
        const std::vector<double> v =
            profile(visibility(scene, "plateaus", with({}, "falloff", falloff)), scene.camera);
        double outer = 0.0, whole = 0.0, largest = -1.0, least = 1.0;
        int outer_count = 0, count = 0;
        const auto kind = static_cast<plateau::Falloff>(falloff == std::string{"linear"}       ? 0
                                                        : falloff == std::string{"sine"}       ? 1
                                                        : falloff == std::string{"smoothstep"} ? 2
                                                                                               : 3);
        for (std::size_t i = 0; i < v.size(); ++i) {
            const double x = scenes::column_x(scene.camera, static_cast<int>(i)) / w;
            if (std::abs(x) < 1.0) {
                whole += v[i];
                ++count;
                if (x > 0.0) {
                    outer += v[i];
                    ++outer_count;
                }
                largest = std::max(largest, v[i] - plateau::disc_cut(x));
                least = std::min(least, v[i] - plateau::disc_cut(x));
                if (std::abs(x) > 0.06) {
                    EXPECT_NEAR(v[i], x > 0.0 ? plateau::falloff(kind, x) : 0.0, 0.004) << falloff << " " << x;
                }
            }
        }
        const double mean = falloff == std::string{"disc"} ? 0.7878 : 0.5;
        // Half a texel of the texture, over which the lookup spreads a jump at the edge, and half a pixel.
        const double spread = (2.0 / 1020 + 2.0 / 1024) * (mean > 0.5 ? 0.5 : 0.0) / w;
        EXPECT_NEAR(outer / outer_count, mean, 0.006) << falloff;
        EXPECT_NEAR(whole / count, 0.5 * mean, 0.006 + spread) << falloff;
        if (falloff == std::string{"linear"}) {
            EXPECT_LE(largest, 0.002);
            EXPECT_NEAR(least, -0.5, 0.01);
        }
    }
}

// E1: outside the hard shadow lambda is the distance, in the light's plane, of the light's centre from the casters
// carried there, in units of the light's own shape.
TEST_F(PlateausGl, LambdaIsTheDistanceOfTheBackProjectedCastersInTheLightsPlane) {
    std::mt19937 random{3};
    Light tilted = disc_light({0.6, -0.4, 5.0}, 0.5);
    tilted.half_u_ws = {0.45, 0.0, 0.15};
    tilted.half_v_ws = 0.9 * glm::cross(glm::normalize(tilted.half_u_ws), {0.1, 0.4, 0.0});
    tilted.direction_ws = -glm::normalize(glm::cross(tilted.half_u_ws, tilted.half_v_ws));
    const std::vector<std::pair<std::string, Light>> lights{
        {"disc", disc_light({0.6, -0.4, 5.0}, 0.5)},
        {"rectangle", scenes::rectangle_light({0.6, -0.4, 5.0}, 1.0, 0.6)},
        {"tilted", tilted},
        {"polygon", triangle_light({0.6, -0.4, 5.0}, 0.6)},
        {"ball", scenes::point_light({2.0, -1.0, 4.0}, 0.4)},
        {"sun", scenes::sun_light({0.7, 0.4, -1.0}, 0.2)}};
    for (const auto& [name, light] : lights) {
        std::vector<Instance> casters;
        for (int i = 0; i < 3; ++i) {
            casters.push_back(scenes::place(tetrahedron(random, 0.7), "caster", {0.7 * i - 0.7, 0.3 * i, 1.4}));
        }
        casters.push_back(scenes::place(scenes::sphere(6, false), "ball", {0.9, -0.9, 1.3}));
        casters.back().world_from_local *= glm::dmat4{0.4, 0, 0, 0, 0, 0.3, 0, 0, 0, 0, 0.4, 0, 0, 0, 0, 1};
        casters.push_back(scenes::place(star(0.3), "star", {-0.8, 0.9, 0.9}));
        for (const char* edges : {"all", "silhouette"}) {
            const Settings settings = with({{"size", 160}}, "edges", edges);
            const std::vector<BakedTexture> textures = bake(over_floor(light, casters, 2.5), settings);
            ASSERT_EQ(textures.size(), 1U);
            std::vector<std::pair<glm::dvec3, glm::dvec3>> all;
            for (const Instance& caster : casters) {
                const auto some = edges_of(caster, light, edges == std::string{"silhouette"});
                all.insert(all.end(), some.begin(), some.end());
            }
            double largest = 0.0;
            int compared = 0;
            for (int y = 0; y < textures[0].height_px; y += 2) {
                for (int x = 0; x < textures[0].width_px; x += 2) {
                    if (!clear_of_umbra(textures[0], x, y)) {
                        continue;
                    }
                    double expected = 1.0;
                    for (const auto& edge : all) {
                        expected = std::min(expected, back_projected(texel_ws(textures[0], x, y), edge, light));
                    }
                    largest = std::max(largest, std::abs(at(textures[0], x, y) - expected));
                    compared += expected < 1.0 ? 1 : 0;
                }
            }
            EXPECT_LE(largest, 2.0 / 255.0) << name << " " << edges;
            EXPECT_GT(compared, 200) << name;
        }
    }
}

// E2: lambda = 1 where and only where the whole light is seen.
TEST_F(PlateausGl, TheOuterBorderIsThatOfTheTruth) {
    std::mt19937 random{5};
    for (const Light& light : {disc_light({0.6, -0.4, 5.0}, 0.5), scenes::rectangle_light({0.3, -0.4, 5.0}, 1.0, 0.6),
                               scenes::point_light({2.0, -1.0, 4.0}, 0.4), scenes::sun_light({0.7, 0.4, -1.0}, 0.2)}) {
        const Scene scene =
            over_floor(light, {scenes::place(tetrahedron(random, 0.8), "caster", {0, 0, 1.2})}, 2.0, 64);
        const std::vector<float> v = visibility(scene, "plateaus", with({}, "edges", "all"));
        const Reference truth = renderer().reference(0, {.standard_error = 0.01}, control_);
        int darker = 0, lighter = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            lighter += v[i] >= 1.0F && truth.area[i] < 0.999F ? 1 : 0;
            darker += v[i] <= 0.85F && truth.area[i] >= 1.0F ? 1 : 0;
        }
        EXPECT_LE(lighter, 2) << to_string(light.kind);
        EXPECT_LE(darker, 2) << to_string(light.kind);
    }
}

// E3 and E5.
TEST_F(PlateausGl, AtTheContactThePenumbraHasNoWidth) {
    const auto wall = scenes::place(scenes::box({-1.0F, -0.05F, 0.0F}, {1.0F, 0.05F, 1.0F}), "wall");
    const Scene scene = over_floor(disc_light({0.0, -3.0, 5.0}, 0.6), {wall}, 2.0, 64);
    for (const BakedTexture& texture : bake(scene, {{"size", 512}})) {
        for (int y = 0; y < texture.height_px; ++y) {
            for (int x = 0; x < texture.width_px; ++x) {
                const glm::dvec3 p = texel_ws(texture, x, y);
                if (std::abs(p.x) < 0.9 && p.y < -0.07 && p.y > -0.2) {  // the lit side, up to the foot
                    ASSERT_EQ(at(texture, x, y), 1.0F) << p.x << " " << p.y;
                }
            }
        }
    }
}

TEST_F(PlateausGl, AFlatCasterLooksTheSameFromSilhouettesFacingTrianglesAndAllEdges) {
    Instance sheet = scenes::place(scenes::sheet(-0.6, 0.5, -0.4, 0.7), "sheet", {0.1, 0.0, 1.0});
    for (const Light& light :
         {disc_light({0.8, -0.4, 4.0}, 0.5), scenes::rectangle_light({0.3, -0.4, 5.0}, 1.0, 0.6)}) {
        const Scene scene = over_floor(light, {sheet}, 1.6, 64);
        const auto silhouettes = bake(scene, {{"size", 128}});
        for (const char* edges : {"facing", "all"}) {
            const auto others = bake(scene, with({{"size", 128}}, "edges", edges));
            EXPECT_LE(largest_difference(silhouettes[0].visibility, others[0].visibility), 2e-3) << edges;
        }
        for (const char* sheets : {"bilinear", "tess"}) {  // equal radii: flat quads
            const auto others = bake(scene, with(with({{"size", 128}}, "light_shape", "disc"), "sheet_mode", sheets));
            const auto envelope = bake(scene, with({{"size", 128}}, "light_shape", "disc"));
            EXPECT_LE(largest_difference(envelope[0].visibility, others[0].visibility), 2e-3) << sheets;
        }
    }
}

// B3: too light in gaps. A slit under a line across it is exact, a square hole is not.
TEST_F(PlateausGl, SlitsAreExactAcrossALinearLightAndSquareHolesTooLight) {
    const double w = 0.5 / 3.0;  // R h / (H - h) with R = 0.5, H = 4, h = 1
    const auto sheet_at = [](double x0, double x1, double y0, double y1) {
        return scenes::place(scenes::sheet(x0, x1, y0, y1), "sheet", {0, 0, 1.0});
    };
    const double hole = 0.75;  // on the sheet per metre on the floor
    for (const double x : {0.2, kPi / 8, 0.6}) {
        const double half = hole * x * w;
        const std::vector<Instance> slit{sheet_at(-5, -half, -5, 5), sheet_at(half, 5, -5, 5)};
        const Scene scene = over_floor(disc_light({0, 0, 4}, 0.5), slit, 0.02, 8);
        EXPECT_NEAR(visibility(scene, "plateaus")[36], x, 0.05) << x;  // the middle: truth of a linear light
        const std::vector<Instance> square{sheet_at(-5, -half, -5, 5), sheet_at(half, 5, -5, 5),
                                           sheet_at(-half, half, -5, -half), sheet_at(-half, half, half, 5)};
        const Scene pierced = over_floor(disc_light({0, 0, 4}, 0.5), square, 0.02, 8);
        const double error = visibility(pierced, "plateaus")[36] - 4.0 * x * x / kPi;
        EXPECT_NEAR(error, x - 4.0 * x * x / kPi, 0.05) << x;
        EXPECT_LE(error, kPi / 16 + 0.02);  // worst at pi/8
    }
}

// B4: the umbra never shrinks.
TEST_F(PlateausGl, ADiscHighUpKeepsItsWholeUmbra) {
    auto disc = std::make_shared<Mesh>();
    disc->name = "disc";
    disc->positions_local.emplace_back(0.0F, 0.0F, 0.0F);
    for (unsigned i = 0; i < 64; ++i) {
        disc->positions_local.emplace_back(0.3 * std::cos(2 * kPi * i / 64), 0.3 * std::sin(2 * kPi * i / 64), 0.0);
        disc->triangles.emplace_back(0, 1 + i, 1 + (i + 1) % 64);
    }
    const Scene scene = over_floor(disc_light({0, 0, 4}, 0.8), {scenes::place(disc, "disc", {0, 0, 3})}, 5.0, 64);
    const std::vector<float> v = visibility(scene, "plateaus");
    const double umbra = 0.3 * 4.0, w = 0.8 * 3.0;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            const double s =
                glm::length(glm::dvec2{scenes::column_x(scene.camera, x), scenes::column_x(scene.camera, y)});
            const double value = v[static_cast<std::size_t>(64 * y + x)];
            const double truth = 1.0 - plateau::lens(s, umbra, w) / (kPi * w * w);
            if (std::abs(s - umbra) > 0.1) {
                EXPECT_NEAR(value, std::clamp((s - umbra) / w, 0.0, 1.0), 0.01) << s;
            }
            EXPECT_LE(value, truth + 0.01) << s;  // one convex caster is never too light
        }
    }
    EXPECT_EQ(v[64 * 32 + 32], 0.0F);  // truth 1 - (0.3 / 0.6)^2 = 0.75
}

// The table of section 3: mean, RMS, least and largest error over all that is penumbra in truth or plateau.
TEST_F(PlateausGl, ErrorsOfTheReferenceRunAreThoseOfTheSpecification) {
    const auto cube = scenes::place(scenes::box({-0.5F, -0.5F, 0.0F}, {0.5F, 0.5F, 1.0F}), "cube");
    const auto slab = scenes::place(scenes::box({-0.6F, -0.4F, 0.0F}, {0.6F, 0.4F, 0.2F}), "slab", {0, 0, 1.5});
    struct Row {
        const char* name;
        glm::dvec3 light;
        Instance caster;
        Settings settings;
        double mean, rms, least, largest;
        double half_m, tolerance;  // window of the 128 x 128 points: the figures hang on how these meet the penumbra
    };
    const Settings linear = with({}, "radius_model", "linear");
    const auto k = [&](double value) {
        Settings settings = linear;
        settings["k"] = value;
        return settings;
    };
    for (const Row& row :
         {Row{"cube", {0, 0, 5}, cube, {}, -0.281, 0.316, -0.635, 0.0, 2.5, 0.004},
          Row{"cube, sine", {0, 0, 5}, cube, with({}, "falloff", "sine"), -0.281, 0.339, -0.732, 0.0, 2.5, 0.004},
          Row{"cube, k = R/H", {0, 0, 5}, cube, k(0.1), -0.217, 0.278, -0.635, 0.032, 2.5, 0.004},
          Row{"cube, k = 2R/H", {0, 0, 5}, cube, k(0.2), -0.332, 0.372, -0.710, 0.0, 2.5, 0.004},
          Row{"cube, oblique", {3, 2, 5}, cube, {}, -0.246, 0.298, -0.719, 0.0, 3.0, 0.01},
          Row{"slab, all edges", {0.7, 0.3, 5}, slab, with({}, "edges", "all"), -0.279, 0.323, -0.725, 0.0, 1.6, 0.004},
          Row{"slab", {0.7, 0.3, 5}, slab, {}, -0.274, 0.320, -0.725, 0.014, 1.6, 0.004}}) {
        const Scene scene = over_floor(disc_light(row.light, 0.5), {row.caster}, row.half_m, 128);
        const std::vector<float> v = visibility(scene, "plateaus", row.settings);
        const Reference truth = renderer().reference(0, {.standard_error = 0.006}, control_);
        double sum = 0.0, squares = 0.0, least = 1.0, largest = -1.0;
        int count = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            const float sliver = 1.0F / 1800;  // the least part of the light that the specification's truth can see
            if ((truth.area[i] > sliver && truth.area[i] < 1.0F - sliver) || (v[i] > 0.0F && v[i] < 1.0F)) {
                const double error = static_cast<double>(v[i]) - truth.area[i];
                sum += error;
                squares += error * error;
                least = std::min(least, error);
                largest = std::max(largest, error);
                ++count;
            }
        }
        EXPECT_NEAR(sum / count, row.mean, row.tolerance) << row.name;
        EXPECT_NEAR(std::sqrt(squares / count), row.rms, row.tolerance) << row.name;
        EXPECT_NEAR(least, row.least, 0.07) << row.name;
        EXPECT_NEAR(largest, row.largest, 0.05) << row.name;
    }
}

// A wall that leans makes radii unequal: two triangles show the artefact, more cells take it away.
TEST_F(PlateausGl, TessellatedSheetsErrByTheirCellsAndBilinearOnesByTheGap) {
    const auto wall =
        scenes::mesh("wall", {{-0.7F, 0.0F, 0.3F}, {0.7F, 0.0F, 2.2F}, {-0.2F, -1.2F, 1.2F}}, {{0, 1, 2}});
    const Light light = disc_light({0.0, 0.0, 5.0}, 0.7);
    const Scene scene = over_floor(light, {scenes::place(wall, "wall")}, 2.2, 64);
    const Settings base = with({{"size", 256}}, "light_shape", "disc");
    const auto envelope = bake(scene, base);
    const auto bilinear = bake(scene, with(base, "sheet_mode", "bilinear"));
    double cell = 0.0, gap = 0.0;
    std::vector<double> radius;
    std::vector<glm::dvec2> s;
    for (const glm::vec3& p : wall->positions_local) {
        s.push_back(plateau::project(glm::dvec3{p}, {light.position_ws, 1.0}));
        radius.push_back(0.7 * plateau::image_scale(p.z, {light.position_ws, 1.0}));
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        gap = std::max(gap, plateau::envelope_gap((radius[i] - radius[j]) / glm::length(s[i] - s[j])));
        cell = std::max(cell, plateau::cell_error(radius[i], radius[j], 1));
    }
    double lighter = 0.0;
    for (std::size_t i = 0; i < envelope[0].visibility.size(); ++i) {
        const double difference = static_cast<double>(bilinear[0].visibility[i]) - envelope[0].visibility[i];
        EXPECT_GE(difference, -2e-3);
        lighter = std::max(lighter, difference);
    }
    EXPECT_LE(lighter, gap + 2e-3);
    EXPECT_GE(lighter, 0.5 * gap);
    for (const int cells : {1, 4, 0}) {
        Settings settings = with(base, "sheet_mode", "tess");
        settings["cells"] = cells;
        const double difference = largest_difference(bake(scene, settings)[0].visibility, bilinear[0].visibility);
        if (cells == 1) {
            EXPECT_LE(difference, cell + 2.0 / 255.0);
            EXPECT_GE(difference, 0.5 * cell);  // else the artefact is not shown
        } else {
            EXPECT_LE(difference, cells == 0 ? 3.0 / 255.0 : 0.5 * cell);
        }
    }
}

TEST_F(PlateausGl, FansAreLighterThanConesByTheirPolygonAndEachIsDrawnOnce) {
    const auto ball = scenes::place(scenes::sphere(8, false), "ball", {0, 0, 1.6});
    const Scene scene = over_floor(disc_light({0.6, -0.4, 5.0}, 0.5), {ball}, 2.6, 64);
    const Settings bilinear = with({{"size", 160}}, "sheet_mode", "bilinear");
    const auto analytic = bake(scene, bilinear);
    for (const int segments : {16, 36}) {
        Settings settings = with(bilinear, "cones", "fan");
        settings["segments"] = segments;
        const auto fans = bake(scene, settings);
        double lighter = 0.0;
        for (std::size_t i = 0; i < fans[0].visibility.size(); ++i) {
            const double difference = static_cast<double>(fans[0].visibility[i]) - analytic[0].visibility[i];
            EXPECT_GE(difference, -2e-3);
            lighter = std::max(lighter, difference);
        }
        EXPECT_LE(lighter, 1.0 / std::cos(kPi / segments) - 1.0 + 3e-3) << segments;
    }
    // Without corners in the records the mailbox keeps a vertex from sending its cone for each of its edges.
    for (const char* edges : {"facing", "all"}) {
        const auto all = bake(scene, with(bilinear, "edges", edges));
        const auto envelope = bake(scene, with({{"size", 160}}, "edges", edges));
        for (std::size_t i = 0; i < all[0].visibility.size(); ++i) {
            EXPECT_GE(all[0].visibility[i], envelope[0].visibility[i] - 2e-3) << edges;
        }
    }
}

// Every corner of an outline comes with one edge alone, so cones need no mailbox.
TEST_F(PlateausGl, RecordsCarryEachCornerOnce) {
    const auto ball = scenes::sphere(12, false);
    const Adjacency adjacency = make_adjacency(*ball);
    std::vector<std::uint32_t> starts;
    for (const SilhouetteEdge& edge : find_silhouettes(*ball, adjacency, {3.0, 1.0, 4.0, 1.0}, false)) {
        EXPECT_NE(edge.z, edge.a);
        starts.push_back(edge.a);
    }
    std::sort(starts.begin(), starts.end());
    EXPECT_EQ(std::adjacent_find(starts.begin(), starts.end()), starts.end());
}

TEST_F(PlateausGl, WidthZeroIsTheHardShadowAndMoreIsDarker) {
    std::mt19937 random{9};
    const auto caster = scenes::place(tetrahedron(random, 0.8), "caster", {0, 0, 1.3});
    const Scene scene = over_floor(disc_light({0.6, -0.4, 5.0}, 0.5), {caster}, 2.0, 64);
    std::vector<float> former;
    for (const double k : {1e-6, 0.02, 0.1, 0.3, 1.0, 10.0}) {
        Settings settings = with({{"size", 128}}, "radius_model", "linear");
        settings["k"] = k;
        const std::vector<float> v = bake(scene, settings)[0].visibility;
        for (std::size_t i = 0; i < v.size(); ++i) {
            if (k == 1e-6) {
                EXPECT_TRUE(v[i] == 0.0F || v[i] == 1.0F);
            } else {
                EXPECT_LE(v[i], former[i] + 1e-5);
            }
        }
        former = v;
    }
}

TEST_F(PlateausGl, AnotherCasterOnlyDarkens) {
    std::mt19937 random{11};
    const auto first = scenes::place(tetrahedron(random, 0.8), "first", {-0.3, 0, 1.3});
    const auto second = scenes::place(tetrahedron(random, 0.6), "second", {0.5, 0.2, 0.9});
    const Light light = scenes::rectangle_light({0.6, -0.4, 5.0}, 1.0, 0.7);
    const auto one = bake(over_floor(light, {first}, 2.0, 64), {{"size", 128}});
    const auto two = bake(over_floor(light, {first, second}, 2.0, 64), {{"size", 128}});
    for (std::size_t i = 0; i < one[0].visibility.size(); ++i) {
        EXPECT_LE(two[0].visibility[i], one[0].visibility[i]);
    }
}

TEST_F(PlateausGl, TrianglesInAnotherOrderMakeTheSameBits) {
    Scene scene = picture_scene(scenes::point_light({0.8, -0.6, 4.0}, 0.4));
    scene.camera.width_px = 160;
    scene.camera.height_px = 120;
    const std::vector<float> before = visibility(scene, "plateaus");
    std::mt19937 random{13};
    for (Instance& instance : scene.instances) {
        auto shuffled = std::make_shared<Mesh>(*instance.mesh);
        std::shuffle(shuffled->triangles.begin(), shuffled->triangles.end(), random);
        instance.mesh = shuffled;
    }
    EXPECT_EQ(before, visibility(scene, "plateaus"));
}

TEST_F(PlateausGl, CastersBelowThePlaneOrAboveTheLightThrowNothing) {
    const Light light = disc_light({0, 0, 3}, 0.4);
    const auto box = scenes::box({-0.3F, -0.3F, -0.2F}, {0.3F, 0.3F, 0.2F});
    for (const double z : {-1.0, 3.5}) {
        for (const float v : visibility(over_floor(light, {scenes::place(box, "box", {0, 0, z})}), "plateaus")) {
            ASSERT_EQ(v, 1.0F) << z;
        }
    }
    // Through the plane, and through the light's own height: finite, and dark in the middle.
    for (const double z : {0.0, 2.9}) {
        const std::vector<float> v = visibility(over_floor(light, {scenes::place(box, "box", {0, 0, z})}), "plateaus");
        for (const float value : v) {
            ASSERT_TRUE(value >= 0.0F && value <= 1.0F);
        }
        EXPECT_EQ(v[48 * 96 + 48], 0.0F) << z;
    }
}

TEST_F(PlateausGl, ALightNearTheHorizonIsLeftToTheDepthMap) {
    const auto box = scenes::place(scenes::box({-0.3F, -0.3F, 0.0F}, {0.3F, 0.3F, 0.4F}), "box");
    const Scene low = over_floor(scenes::sun_light({1.0, 0.0, -0.004}, 0.05), {box}, 2.0, 64);
    const Scene wide = over_floor(scenes::sun_light({1.0, 0.0, -0.1}, 0.5), {box}, 2.0, 64);
    for (const Scene& scene : {low, wide}) {
        EXPECT_EQ(visibility(scene, "plateaus"), visibility(scene, "shadow_map"));
    }
}

TEST_F(PlateausGl, ALightWithoutExtentIsTheHardShadowMapToTheBit) {
    for (Scene scene : {picture_scene(scenes::point_light({0.8, -0.6, 4.0}, 0.0)),
                        picture_scene(scenes::sun_light({1.0, 0.3, -0.6}, 0.0))}) {
        scene.camera.width_px = 160;
        scene.camera.height_px = 120;
        EXPECT_EQ(visibility(scene, "plateaus"), visibility(scene, "shadow_map"));
        EXPECT_EQ(visibility(scene, "plateaus", {}, true), visibility(scene, "shadow_map"));
        EXPECT_TRUE(rule_fires(scene, "light-without-extent"));
        EXPECT_FALSE(rule_fires(scene, "light-without-extent", true));
    }
}

TEST_F(PlateausGl, RulesFireWhereTheyShouldAndNowhereElse) {
    const auto box = scenes::place(scenes::box({-0.3F, -0.3F, 0.5F}, {0.3F, 0.3F, 0.9F}), "box");
    const Scene plain = over_floor(disc_light({0, 0, 4}, 0.4), {box});
    EXPECT_TRUE(rule_fires(plain, "every-receiver-on-a-plane"));
    EXPECT_FALSE(rule_fires(plain, "every-receiver-on-a-plane", true));
    EXPECT_EQ(visibility(plain, "plateaus"), visibility(plain, "plateaus", {}, true));
    EXPECT_FALSE(rule_fires(picture_scene(disc_light({0.8, -0.6, 4.0}, 0.4)), "every-receiver-on-a-plane"));
    const Scene tiny = over_floor(disc_light({0, 0, 4}, 1e-4), {box});
    EXPECT_TRUE(rule_fires(tiny, "penumbra-under-half-a-texel"));
    EXPECT_FALSE(rule_fires(tiny, "penumbra-under-half-a-texel", true));
    EXPECT_EQ(visibility(tiny, "plateaus"), visibility(tiny, "plateaus", {}, true));
    EXPECT_FALSE(rule_fires(plain, "penumbra-under-half-a-texel"));
}

// The two-sided form must not let light through where casters touch or hide each other.
TEST_F(PlateausGl, TheInnerSideDoesNotLeakBetweenCastersThatTouchOrOverlap) {
    const Light light = scenes::rectangle_light({0.0, 0.0, 4.0}, 1.0, 1.0);
    const auto half = [](double x0, double x1, double z) {
        return scenes::place(scenes::box({x0, -1.5, 0.0}, {x1, 1.5, 0.2}), "box", {0, 0, z});
    };
    struct Case {
        const char* name;
        std::vector<Instance> casters;
    };
    for (const Case& c : {Case{"abutting", {half(-1.5, 0.0, 1.0), half(0.0, 1.5, 1.0)}},
                          Case{"overlapping", {half(-1.5, 0.2, 1.0), half(-0.2, 1.5, 1.3)}},
                          Case{"one under the other", {half(-1.5, 1.5, 1.5), half(-0.3, 0.3, 0.6)}}}) {
        const Scene scene = over_floor(light, c.casters, 0.9, 96);
        for (const float v : visibility(scene, "plateaus", with({}, "sides", "both"))) {
            ASSERT_LE(v, 0.01F) << c.name;
        }
    }
}

TEST_F(PlateausGl, BytesAndDepthsHoldTheSameImageToTheirPrecision) {
    const Scene scene = picture_scene(scenes::rectangle_light({0.8, -0.6, 4.0}, 0.8, 0.4));
    const auto exact = bake(scene, {{"size", 128}});
    EXPECT_LE(
        largest_difference(exact[0].visibility, bake(scene, with({{"size", 128}}, "store", "byte"))[0].visibility),
        0.51 / 255);
    Settings depth = with({{"size", 128}}, "store", "depth");
    EXPECT_LE(largest_difference(exact[0].visibility, bake(scene, depth)[0].visibility), 1.01 / 65535);
    depth["hither"] = 0.25;  // a sub-range of the depth buffer
    depth["yon"] = 0.75;
    EXPECT_LE(largest_difference(exact[0].visibility, bake(scene, depth)[0].visibility), 2.02 / 65535);
}

// 2.10: on a receiver at height z the penumbra is R (h - z) H / ((H - h)(H - z)) wide in the plane's units.
TEST_F(PlateausGl, OffThePlanesPenumbraeAreNarrowedByTheReceiversHeight) {
    Scene scene = scenes::straight_edge(disc_light({0, 0, 4}, 0.5), 1.0, 0.0, 512, 1.0);
    scene.instances.push_back(scenes::place(scenes::sheet(-3, 3, -3, 3), "table", {0, 0, 0.4}));
    scene.instances.push_back(scenes::place(scenes::sheet(5, 9, -3, 3), "unseen"));
    // The table hides the ground but for a strip, which is the plane that is chosen.
    scene.camera = scenes::camera_from_above(1.0, 512, 64);
    scene.camera.half_width_m = 4.0;
    Settings settings = with({{"size", 2048}}, "plane", "ground");
    const std::vector<double> narrowed =
        profile(visibility(scene, "plateaus", with(settings, "off_planes", "narrowed")), scene.camera);
    const std::vector<double> projected =
        profile(visibility(scene, "plateaus", with(settings, "off_planes", "projected")), scene.camera);
    const double truth = 0.5 * 0.6 / 3.0;           // R (h - z) / (H - h)
    const double on_table = 0.5 / 3.0 * 3.6 / 4.0;  // the plane's own width, carried up to the table
    const auto width = [&](const std::vector<double>& v) {
        double lit = 0.0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            const double x = scenes::column_x(scene.camera, static_cast<int>(i));
            lit += x > 0.0 && x < 1.0 ? (1.0 - v[i]) * 8.0 / 512 : 0.0;
        }
        return 2.0 * lit;  // linear: the mean over the width is 1/2
    };
    EXPECT_NEAR(width(narrowed), truth, 0.15 * truth);
    EXPECT_NEAR(width(projected), on_table, 0.15 * truth);
}

TEST_F(PlateausGl, AReceiverAboveItsCasterIsLit) {
    Scene scene = picture_scene(disc_light({0.0, 0.0, 6.0}, 0.6));
    scene.instances.resize(1);
    scene.instances.push_back(scenes::place(scenes::box({-0.2F, -0.2F, 0.0F}, {0.2F, 0.2F, 0.5F}), "low", {0, 0, 0.2}));
    scene.instances.push_back(scenes::place(scenes::sphere(24, false), "ball", {0.0, 0.0, 2.2}));
    scene.camera = scenes::camera_from_above(0.5, 64, 64);
    for (const char* off_planes : {"hard", "narrowed"}) {
        for (const float v : visibility(scene, "plateaus", with({}, "off_planes", off_planes))) {
            ASSERT_EQ(v, 1.0F) << off_planes;
        }
    }
}

// Where nobody reads slopes under the hard shadow they are not computed there: the texture is the same.
TEST_F(PlateausGl, SlopesUnderTheUmbraAreLeftOutWithoutAChange) {
    const Scene scene = picture_scene(scenes::rectangle_light({0.8, -0.6, 4.0}, 0.8, 0.4));
    const auto skipped = bake(scene, with({{"size", 256}}, "off_planes", "hard"));
    const auto all = bake(scene, with({{"size", 256}}, "off_planes", "narrowed"));
    ASSERT_FALSE(skipped.empty());
    // Windows differ by what is added for receivers off the planes; the pixels see both.
    const std::vector<float> a = visibility(scene, "plateaus", with({}, "off_planes", "hard"));
    const std::vector<float> b = visibility(scene, "plateaus", with({}, "off_planes", "narrowed"));
    const auto view = renderer().view(control_);
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (view->instance[i] == 0) {
            sum += std::abs(a[i] - b[i]);
            ++count;
        }
    }
    EXPECT_LE(sum / static_cast<double>(count), 2e-3);
    EXPECT_EQ(skipped.size(), all.size());
}

// The saving is exact: whatever is drawn, and however it is stored, the same bits with and without it.
TEST_F(PlateausGl, HiddenSilhouettesAndUnseenTexelsAreLeftOutWithoutAChange) {
    const std::vector<Light> lights{disc_light({0.8, -0.6, 4.0}, 0.4),
                                    scenes::rectangle_light({-0.8, 0.6, 4.0}, 1.2, 0.4),
                                    scenes::point_light({0.8, -0.6, 3.0}, 0.4),
                                    scenes::sun_light({1.0, 0.3, -0.6}, 0.2), triangle_light({0.3, 0.2, 3.0}, 0.5)};
    const std::vector<Settings> variants{
        {},
        with({}, "sides", "both"),
        with({}, "edges", "all"),
        with({}, "sheet_mode", "bilinear"),
        with(with({}, "sheet_mode", "bilinear"), "cones", "fan"),
        with({{"cells", 3}}, "sheet_mode", "tess"),
        with({}, "store", "byte"),
        with({}, "store", "depth"),
        with(with({}, "off_planes", "narrowed"), "plane", "ground"),
    };
    for (const Light& light : lights) {
        Scene scene = picture_scene(light);
        scene.camera.width_px = 120;
        scene.camera.height_px = 90;
        for (std::size_t i = 0; i < variants.size(); ++i) {
            Settings settings = variants[i];
            settings["size"] = 256;
            ASSERT_EQ(visibility(scene, "plateaus", settings), visibility(scene, "plateaus", settings, true))
                << "light " << static_cast<int>(light.kind) << " variant " << i;
        }
    }
}

// A caster nearly as high as the light: its penumbrae fill the texture, edge by edge.
TEST_F(PlateausGl, WideSlopesAreCutToTilesWithoutAChange) {
    for (const Light& light : {disc_light({0.2, 0.1, 2.0}, 0.5), scenes::rectangle_light({0.2, 0.1, 2.0}, 1.2, 0.5),
                               scenes::point_light({0.2, 0.1, 2.0}, 0.4), triangle_light({0.2, 0.1, 2.0}, 0.5)}) {
        Light tilted = light;
        const glm::dmat3 turn{{0.9, 0.0, -std::sqrt(0.19)}, {0.0, 1.0, 0.0}, {std::sqrt(0.19), 0.0, 0.9}};
        tilted.half_u_ws = turn * light.half_u_ws;
        tilted.half_v_ws = turn * light.half_v_ws;
        tilted.direction_ws = turn * light.direction_ws;
        for (glm::dvec3& corner : tilted.corners_ws) {
            corner = light.position_ws + turn * (corner - light.position_ws);
        }
        for (const Light& used : {light, tilted}) {
            Instance ball = scenes::place(scenes::sphere(8, false), "ball");
            ball.world_from_local = glm::dmat4{0.4};
            ball.world_from_local[3] = {0.3, -0.2, 1.0, 1.0};
            const auto box =
                scenes::place(scenes::box({-0.1F, -0.3F, 0.0F}, {0.1F, 0.3F, 1.2F}), "box", {-0.7, 0.4, 0.0});
            const Scene scene = over_floor(used, {ball, box}, 2.0, 96);
            for (const char* sides : {"outer", "both"}) {
                Settings settings = with({{"size", 512}}, "sides", sides);
                renderer().set_scene(scene);
                const VisibilityResult cut = renderer().visibility(0, {"plateaus", settings}, false, control_);
                const VisibilityResult all = renderer().visibility(0, {"plateaus", settings}, true, control_);
                EXPECT_EQ(cut.visibility, all.visibility) << static_cast<int>(light.kind) << " " << sides;
                const Job unsifted{.technique = "plateaus",
                                   .settings = settings,
                                   .keep_rules = {"silhouette-under-umbra", "texel-without-pixel"}};
                const VisibilityResult tiled = renderer().visibility(0, unsifted, false, control_);
                EXPECT_EQ(cut.visibility, tiled.visibility) << static_cast<int>(light.kind) << " " << sides;
                const auto pieces = [](const VisibilityResult& result) {
                    return std::ranges::find(result.statistics, "slope_pieces", &Statistic::id)->value;
                };
                EXPECT_LT(pieces(cut), pieces(tiled)) << "of tiles that are black or that no pixel looks up";
                EXPECT_GT(pieces(cut), 0.0) << static_cast<int>(light.kind) << " " << sides;
                EXPECT_EQ(pieces(all), 0.0) << "kept whole, nothing is cut";
            }
        }
    }
}

TEST_F(PlateausGl, ABoxUnderAnotherOnesUmbraHasNoSlopes) {
    const auto slab = scenes::place(scenes::box({-0.8F, -0.8F, 1.0F}, {0.8F, 0.8F, 1.1F}), "slab");
    const auto box_at = [&](double x) {
        return scenes::place(scenes::box({-0.2F, -0.2F, 0.2F}, {0.2F, 0.2F, 0.5F}), "box", {x, 0, 0});
    };
    const auto counts = [&](const std::vector<Instance>& casters, const char* sides) {
        renderer().set_scene(over_floor(disc_light({0, 0, 4}, 0.4), casters, 2.0, 128));
        const Settings settings = with({{"size", 512}}, "sides", sides);
        glm::ivec2 found{0};
        for (const Statistic& statistic :
             renderer().visibility(0, {"plateaus", settings}, false, control_).statistics) {
            found.x = statistic.id == "hidden_silhouettes" ? static_cast<int>(statistic.value) : found.x;
            found.y = statistic.id == "silhouettes" ? static_cast<int>(statistic.value) : found.y;
        }
        const std::vector<std::string> views{"primitives"};
        const auto pictures = renderer().debug_images(0, {"plateaus", settings}, views, control_);
        EXPECT_NE(pictures.at(0).image.caption.find(std::to_string(found.x) + " of " + std::to_string(found.y)),
                  std::string::npos);
        return found;
    };
    for (const char* sides : {"outer", "both"}) {
        const glm::ivec2 alone = counts({slab}, sides);
        const glm::ivec2 under = counts({slab, box_at(0.0)}, sides);
        const glm::ivec2 beside = counts({slab, box_at(1.5)}, sides);
        EXPECT_EQ(alone.x, 0) << sides;
        EXPECT_GE(under.y, alone.y + 4) << sides;
        EXPECT_EQ(under.x, under.y - alone.y) << sides;
        EXPECT_EQ(beside.x, 0) << sides;
    }
}

TEST_F(PlateausGl, SlopesUnderTheUmbraAreKeptWhereReceiversOffThePlaneReadThem) {
    const Scene scene = picture_scene(disc_light({0.8, -0.6, 4.0}, 0.4));
    EXPECT_TRUE(rule_fires(scene, "silhouette-under-umbra"));
    EXPECT_TRUE(rule_fires(scene, "texel-without-pixel"));
    EXPECT_TRUE(rule_fires(scene, "slope-never-darkest"));
    for (const char* rule : {"silhouette-under-umbra", "slope-never-darkest", "texel-without-pixel"}) {
        EXPECT_FALSE(rule_fires(scene, rule, true)) << rule;
        renderer().set_scene(scene);
        const Plan plan =
            renderer().visibility(0, {"plateaus", with({}, "off_planes", "narrowed")}, false, control_).plan;
        for (const Step& step : plan.steps) {
            EXPECT_NE(step.rule, rule);  // slopes under the umbra are read there
        }
    }
}

TEST_F(PlateausGl, TheBakedTextureLiesWhereItsCornersSay) {
    const Scene scene = picture_scene(scenes::rectangle_light({0.8, -0.6, 4.0}, 0.8, 0.4));
    const auto textures = bake(scene, {{"size", 512}});
    ASSERT_FALSE(textures.empty());
    const BakedTexture& texture = textures[0];
    EXPECT_EQ(texture.name, "ground");
    const std::vector<float> v = visibility(scene, "plateaus", {{"size", 512}});
    const auto view = renderer().view(control_);
    const glm::dvec3 x = texture.corners_ws[1] - texture.corners_ws[0],
                     y = texture.corners_ws[3] - texture.corners_ws[0];
    EXPECT_NEAR(glm::dot(x, y), 0.0, 1e-9);
    std::size_t compared = 0, differ = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
        if (view->instance[i] == 0) {
            const glm::dvec3 p = view->eye_ws + glm::dvec3{view->position_cr[i]} - texture.corners_ws[0];
            const int column = static_cast<int>(glm::dot(p, x) / glm::dot(x, x) * texture.width_px);
            const int row = static_cast<int>(glm::dot(p, y) / glm::dot(y, y) * texture.height_px);
            ASSERT_TRUE(column >= 0 && column < texture.width_px && row >= 0 && row < texture.height_px);
            differ += std::abs(at(texture, column, row) - v[i]) > 0.1F ? 1 : 0;
            ++compared;
        }
    }
    EXPECT_LE(differ, compared / 50);
    const auto whole = bake(scene, with({{"size", 64}}, "extent", "object"));
    EXPECT_GE(glm::length(whole[0].corners_ws[2] - whole[0].corners_ws[0]), 40.0 * std::sqrt(2.0) - 1.0);
}

}  // namespace
}  // namespace penumbra
