// Which planes get a texture, how large it is, who throws a shadow on it and who looks it up.
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/cone_base.h"
#include "geometry/light_region.h"
#include "passes/light_summary.h"
#include "techniques/plateaus/plateaus.h"

namespace penumbra {

namespace {

constexpr double kClipAtLight = 0.999;  ///< of the light's height: what is higher has no bounded image
constexpr int kBorder_px = 2;

/// Largest height of the casters' boxes over the plane, and the largest distance from the pass's origin.
glm::dvec2 reach_of_casters(const LightSummary& summary, const PlanarReceiver& plane, const glm::dvec3& origin_ws) {
    glm::dvec2 reach{0.0};
    for (const Bounds& box : summary.caster_bounds_ws) {
        const double up = glm::dot(box.half_size(), glm::abs(plane.normal));
        reach.x = std::max(reach.x, plane.height(box.centre()) + up);
        reach.y = std::max(reach.y, glm::length(box.centre() - origin_ws) + box.radius());
    }
    return reach;
}

/// A rectangle around the shadow that a caster's box throws on a plane, plane coordinates; empty: it throws none.
struct Shadow {
    glm::dvec2 low_m{std::numeric_limits<double>::infinity()};
    glm::dvec2 high_m{-std::numeric_limits<double>::infinity()};
    [[nodiscard]] bool meets(const glm::dvec2& from_m, const glm::dvec2& to_m) const noexcept {
        return glm::all(glm::lessThanEqual(low_m, to_m)) && glm::all(glm::greaterThanEqual(high_m, from_m));
    }
};

/// @param heights  least and largest height that casts, metres; below the light's
Shadow shadow_of(const Bounds& box, const PlanarReceiver& plane, const plateau::PlaneLight& light,
                 const glm::dvec2& heights) {
    const glm::dvec3 offset = box.centre() - plane.origin_ws;
    const glm::dvec3 middle{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y), plane.height(box.centre())};
    const glm::dvec3 half{glm::dot(box.half_size(), glm::abs(plane.axis_x)),
                          glm::dot(box.half_size(), glm::abs(plane.axis_y)),
                          glm::dot(box.half_size(), glm::abs(plane.normal))};
    const double lowest = std::max(middle.z - half.z, heights.x);
    const double highest = std::min(middle.z + half.z, heights.y);
    Shadow shadow;
    for (unsigned i = 0; i < 8 && lowest <= highest; ++i) {
        const glm::dvec2 at =
            plateau::project({middle.x + ((i & 1U) != 0 ? half.x : -half.x),
                              middle.y + ((i & 2U) != 0 ? half.y : -half.y), (i & 4U) != 0 ? highest : lowest},
                             light);
        shadow.low_m = glm::min(shadow.low_m, at);
        shadow.high_m = glm::max(shadow.high_m, at);
    }
    return shadow;
}

}  // namespace

Plateaus::Layout Plateaus::lay_out(const LightSummary& summary) const {
    Layout layout;
    const Light& light = *summary.light;
    const View& view = *summary.view;
    layout.origin_ws = summary.receivers_ws.centre();
    PlanarReceiverOptions finding = finding_;
    finding.tolerance_m = plane_tolerance_ * summary.receivers_ws.radius();
    layout.receivers = find_planar_receivers(*summary.scene, view, summary.mask, finding);
    PlanarReceivers& receivers = layout.receivers;

    // Planes over which the light stands too low are left to the depth map.
    std::vector<std::uint8_t> renumbered(receivers.planes.size() + 1, PlanarReceivers::kNone);
    std::vector<PlanarReceiver> served;
    for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
        if (light_serves(receivers.planes[p], light)) {
            renumbered[p] = static_cast<std::uint8_t>(served.size());
            served.push_back(receivers.planes[p]);
        } else {
            receivers.pixels_on_none += receivers.planes[p].pixels;
        }
    }
    if (served.size() != receivers.planes.size()) {
        for (std::uint8_t& p : receivers.plane_of_pixel) {
            p = p == PlanarReceivers::kNone ? p : renumbered[p];
        }
        receivers.planes = std::move(served);
    }

    // Pixels off the planes look up where their light's ray goes on to: a little more of each plane for them.
    std::vector<plateau::PlaneLight> lights;
    lights.reserve(receivers.planes.size());
    for (const PlanarReceiver& plane : receivers.planes) {
        lights.push_back(light_on(plane, light));
    }
    std::vector<glm::dvec2> low;
    std::vector<glm::dvec2> high;
    for (const PlanarReceiver& plane : receivers.planes) {
        low.push_back(plane.low_m);
        high.push_back(plane.high_m);
    }
    for (std::size_t i = 0; receivers.pixels_on_none > 0 && soft_off_planes_ && i < view.size(); ++i) {
        if (summary.mask[i] == 0 || receivers.plane_of_pixel[i] != PlanarReceivers::kNone) {
            continue;
        }
        const glm::dvec3 p_ws = view.eye_ws + glm::dvec3{view.position_cr[i]};
        for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
            const PlanarReceiver& plane = receivers.planes[p];
            const glm::dvec3 offset = p_ws - plane.origin_ws;
            const glm::dvec3 at{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y), plane.height(p_ws)};
            if (at.z > 0.0 && (lights[p].w == 0.0 || at.z < kClipAtLight * lights[p].z)) {
                const glm::dvec2 more = 0.25 * (plane.high_m - plane.low_m);
                const glm::dvec2 s =
                    glm::clamp(plateau::project(at, lights[p]), plane.low_m - more, plane.high_m + more);
                low[p] = glm::min(low[p], s);
                high[p] = glm::max(high[p], s);
            }
        }
    }

    double widest = 0.0;
    for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
        const PlanarReceiver& plane = receivers.planes[p];
        const glm::dvec2 reach = reach_of_casters(summary, plane, layout.origin_ws);
        // Float32 roundings of the casters' own coordinates must not lift the plane's mesh off it.
        const double least = std::max(finding.tolerance_m, 2e-6 * reach.y);
        double largest = std::max(1.01 * reach.x, 2.0 * least);
        if (lights[p].w != 0.0) {
            largest = std::min(largest, kClipAtLight * lights[p].z);
        }
        gpu::PlateauPlane block = make_plateau_plane(plane, light, shape_, layout.origin_ws, {least, largest});
        const double share =
            std::sqrt(static_cast<double>(plane.pixels) / static_cast<double>(receivers.planes[0].pixels));
        const double size = std::max(std::min(64.0, static_cast<double>(size_px_)), std::round(size_px_ * share));
        const glm::dvec2 extent = high[p] - low[p];
        const double longer = std::max({extent.x, extent.y, 4.0 * least});
        const double texel = longer / std::max(1.0, size - 2.0 * kBorder_px);
        const glm::ivec2 size_px =
            glm::max(glm::ivec2{glm::ceil(extent / texel - 1e-9)}, glm::ivec2{1}) + 2 * kBorder_px;
        const glm::dvec2 corner = low[p] - kBorder_px * texel;
        block.window = glm::vec4{glm::vec2{corner}, static_cast<float>(texel), static_cast<float>(1.0 / texel)};
        block.size.x = size_px.x;
        block.size.y = size_px.y;
        const double sigma =
            block.heights.z > 0.0F ? block.heights.z * largest : plateau::image_scale(largest, lights[p]);
        const double cosine = lights[p].z / glm::length(glm::dvec3{lights[p]});
        const double reach_m = shape_.match * std::max(disc_radius(light), light_region(light).radius());
        widest = std::max(widest, sigma * reach_m / cosine / texel);
        if (const double radius = disc_radius(light); radius > 0.0) {
            block.normal.w = static_cast<float>(shape_.least_radius_texels * texel / radius);
        }
        layout.width_px = std::max(layout.width_px, size_px.x);
        layout.height_px = std::max(layout.height_px, size_px.y);
        const bool parallel = block.half_u.z == 0.0F && block.half_v.z == 0.0F && block.dual_v.w == 0.0F;
        const PlateauLight variant = plateau_light(light, shape_);
        layout.frames.push_back(variant.frame != PlateauLight::Frame::Ball && parallel ? PlateauLight::Frame::Parallel
                                                                                       : variant.frame);
        layout.blocks.push_back(block);
    }
    layout.widest_texels = widest;
    layout.hard = !summary.has_extent ||
                  (shape_.k <= 0.0 && shape_.least_radius_texels <= 0.0 && widest < 0.5 && !layout.blocks.empty());
    layout.map = layout.hard || receivers.pixels_on_none > 0 || summary.keeps("every-receiver-on-a-plane");
    return layout;
}

std::vector<std::uint32_t> Plateaus::casters_onto(const LightSummary& summary, const Layout& layout,
                                                  std::size_t plane) {
    const gpu::PlateauPlane& block = layout.blocks[plane];
    const PlanarReceiver& receiver = layout.receivers.planes[plane];
    const plateau::PlaneLight light = light_on(receiver, *summary.light);
    const glm::dvec2 heights{0.5 * static_cast<double>(block.heights.x), block.heights.y};
    const double texel = block.window.z;  // one more all around: roundings
    const glm::dvec2 low = glm::dvec2{block.window} - texel;
    const glm::dvec2 high = low + texel * (glm::dvec2{block.size} + 2.0);
    std::vector<std::uint32_t> casters;
    for (std::size_t c = 0; c < summary.casters.size(); ++c) {
        if (summary.keeps("caster-outside-face") ||
            shadow_of(summary.caster_bounds_ws[c], receiver, light, heights).meets(low, high)) {
            casters.push_back(summary.casters[c]);
        }
    }
    return casters;
}

std::string Plateaus::step_of(const Layout& layout, std::size_t plane) {
    return "plateau " + std::to_string(plane + 1) + ", " + layout.receivers.planes[plane].name;
}

std::vector<std::uint16_t> Plateaus::texels_looked_up(const View& view) const {
    const std::size_t layer = static_cast<std::size_t>(layout_.width_px) * layout_.height_px;
    std::vector<std::uint16_t> wanted(layer * layout_.blocks.size(), 0);
    constexpr double kRounding = 0.05;  // of the shader's texel coordinates, and more
    for (std::size_t i = 0; i < view.size(); ++i) {
        const std::size_t p = layout_.receivers.plane_of_pixel[i];
        if (p >= layout_.blocks.size()) {
            continue;
        }
        const PlanarReceiver& plane = layout_.receivers.planes[p];
        const gpu::PlateauPlane& block = layout_.blocks[p];
        const glm::dvec3 offset = view.eye_ws + glm::dvec3{view.position_cr[i]} - plane.origin_ws;
        const glm::dvec2 at{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y)};
        const glm::dvec2 texel = (at - glm::dvec2{block.window}) / static_cast<double>(block.window.z) - 0.5;
        const glm::ivec2 last = glm::ivec2{block.size} - 1;
        const glm::ivec2 low = glm::clamp(glm::ivec2{glm::floor(texel - kRounding)}, glm::ivec2{0}, last);
        const glm::ivec2 high = glm::clamp(glm::ivec2{glm::floor(texel + kRounding)} + 1, glm::ivec2{0}, last);
        for (int y = low.y; y <= high.y; ++y) {
            std::uint16_t* row = wanted.data() + p * layer + static_cast<std::size_t>(y) * layout_.width_px;
            std::fill(row + low.x, row + high.x + 1, std::uint16_t{0xffff});
        }
    }
    return wanted;
}

}  // namespace penumbra
