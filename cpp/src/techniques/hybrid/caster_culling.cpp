#include "techniques/hybrid/caster_culling.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "passes/centre_map.h"
#include "passes/frame.h"

namespace penumbra {

namespace {

/// Share of its depth that a box is pulled towards the light, so that no caster hides behind its own surface.
constexpr double kPull = 1e-3;

struct Rectangle {
    glm::vec4 low_high{0.0F};
    float depth = 0.0F;
    bool outside = false;
};

/// Nothing if the box comes too near to the light to be seen as a rectangle.
std::optional<Rectangle> rectangle_of(const Bounds& box, const MapFace& face, const glm::dvec3& origin_ws,
                                      int size_px) {
    glm::dvec2 low{std::numeric_limits<double>::infinity()};
    glm::dvec2 high{-low};
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = -nearest;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec3 corner{(i & 1U) != 0 ? box.high.x : box.low.x, (i & 2U) != 0 ? box.high.y : box.low.y,
                                (i & 4U) != 0 ? box.high.z : box.low.z};
        const glm::dvec3 p = face.ls_from_world * (corner - origin_ws);
        nearest = std::min(nearest, p.z);
        farthest = std::max(farthest, p.z);
        const glm::dvec2 at = face.orthographic ? glm::dvec2{p} : glm::dvec2{p} / p.z;
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    if (!face.orthographic && !(nearest > face.near_m)) {
        return farthest > 0.0 ? std::nullopt : std::optional<Rectangle>{Rectangle{.outside = true}};
    }
    const glm::dvec2 size = face.high - face.low;
    const glm::dvec2 texel = size / static_cast<double>(size_px);
    low = 2.0 * (low - texel - face.low) / size - 1.0;
    high = 2.0 * (high + texel - face.low) / size - 1.0;
    Rectangle made;
    made.low_high = {glm::vec2{low}, glm::vec2{high}};
    made.outside = low.x > 1.0 || low.y > 1.0 || high.x < -1.0 || high.y < -1.0;
    const double pulled = nearest - kPull * (face.orthographic ? face.far_m - face.near_m : nearest);
    made.depth = static_cast<float>(face.orthographic ? (face.far_m - pulled) / (face.far_m - face.near_m)
                                                      : face.near_m / pulled);
    return made;
}

}  // namespace

void CasterCulling::test(Frame& frame, CentreMap& map) {
    const LightSummary& summary = frame.summary();
    const MapFrustum& frustum = map.frustum();
    if (map_texture_ != map.texture().name() || targets_.size() != frustum.faces.size()) {
        targets_.clear();
        for (std::size_t i = 0; i < frustum.faces.size(); ++i) {
            targets_.emplace_back("casters in shadow");
            targets_.back().attach_depth(map.texture(), static_cast<int>(i));
        }
        map_texture_ = map.texture().name();
        no_attributes_ = VertexArray::create();
    }
    while (queries_.size() < summary.casters.size()) {
        queries_.push_back(Query::create(GL_ANY_SAMPLES_PASSED));
    }
    conditions_.assign(summary.casters.size(), 0);
    const Program& program =
        frame.device().programs.get({"techniques/hybrid/caster_rectangle.vert", "passes/volume.frag"});
    program.use();
    glBindVertexArray(no_attributes_.name());
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GEQUAL);
    glEnable(GL_DEPTH_CLAMP);
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        std::vector<Rectangle> rectangles;
        bool all = true;
        for (const MapFace& face : frustum.faces) {
            const auto rectangle = rectangle_of(summary.caster_bounds_ws[i], face, frustum.origin_ws, map.size_px());
            all = all && rectangle.has_value();
            rectangles.push_back(rectangle.value_or(Rectangle{}));
        }
        if (!all) {
            continue;
        }
        glBeginQuery(GL_ANY_SAMPLES_PASSED, queries_[i].name());
        for (std::size_t f = 0; f < rectangles.size(); ++f) {
            if (!rectangles[f].outside) {
                targets_[f].bind();
                program.set("low_high", rectangles[f].low_high);
                program.set("depth", rectangles[f].depth);
                glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
            }
        }
        glEndQuery(GL_ANY_SAMPLES_PASSED);
        conditions_[i] = queries_[i].name();
    }
    glBindVertexArray(0);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
}

std::uint32_t CasterCulling::culled() const {
    std::uint32_t count = 0;
    for (const GLuint condition : conditions_) {
        GLuint passed = 1;
        if (condition != 0) {
            glGetQueryObjectuiv(condition, GL_QUERY_RESULT, &passed);
        }
        count += passed == 0 ? 1 : 0;
    }
    return count;
}

}  // namespace penumbra
