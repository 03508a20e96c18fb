#include "passes/edge_space.h"

#include <algorithm>

namespace penumbra {

EdgeRange edge_range(const MapFace& face, double reach_per_w) {
    EdgeRange range;
    // A texel at the deepest receiver may hold a point a little deeper than any visible pixel.
    if (face.orthographic) {
        range.z_low = -1e30;
        range.z_high = face.farthest_m + 1e-2 * (face.far_m - face.near_m);
        range.w_far = -range.z_high;
    } else {
        range.z_high = 1.01 * face.farthest_m;
        range.z_low = std::max(1e-5 * face.farthest_m, 1e-3 * reach_per_w);
        range.w_far = 1.0 / range.z_high;
    }
    return range;
}

void set_edge_space(const Program& program, int face, const EdgeRange& range, const glm::dmat2& ip_from_unit) {
    const glm::dmat2 unit_from_ip = glm::inverse(ip_from_unit);
    const auto columns = [](const glm::dmat2& m) { return glm::vec4{m[0].x, m[0].y, m[1].x, m[1].y}; };
    program.set("face_index", face);
    program.set("edge_range", glm::vec3{glm::dvec3{range.z_low, range.z_high, range.w_far}});
    program.set("unit_from_ip", columns(unit_from_ip));
    program.set("ip_from_unit", columns(ip_from_unit));
}

}  // namespace penumbra
