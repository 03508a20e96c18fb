#include "passes/mask_edges.h"

#include <algorithm>

namespace penumbra {

namespace {

/// A point of the map: texels and w.
using MapPoint = glm::dvec3;

constexpr double kBeyond = 4.0;  // texels around the map in which edges stay as they are

/// The part of a segment, as shares of it, in which `d` <= 0, given its values at both ends.
struct Part {
    double from = 0.0, to = 1.0;
    [[nodiscard]] bool empty() const noexcept { return from > to; }
    void keep_below(double at_a, double at_b) noexcept {
        if (at_a > 0.0 && at_b > 0.0) {
            to = -1.0;
        } else if (at_a > 0.0) {
            from = std::max(from, at_a / (at_a - at_b));
        } else if (at_b > 0.0) {
            to = std::min(to, at_a / (at_a - at_b));
        }
    }
};

MapPoint at(const MapPoint& a, const MapPoint& b, double t) {
    return t <= 0.0 ? a : (t >= 1.0 ? b : a + t * (b - a));
}

gpu::MaskEdge record(const MapPoint& a, const MapPoint& b, bool looked_up) {
    const float flag = looked_up ? 1.0F : 0.0F;
    return {glm::vec4{glm::vec3{a}, flag}, glm::vec4{glm::vec3{b}, flag}};
}

/// p - per_w (w - w_farthest) <= high, and the like below: planes, since p and w are affine in the image.
void keep_in_hull(const MaskFace& mask_face, const glm::dvec3& a_ls, const glm::dvec3& b_ls, Part& kept) noexcept {
    const MapFace& face = mask_face.face;
    const double w_farthest = mask_w(face, face.farthest_m);
    for (int axis = 0; axis < 2; ++axis) {
        const double reach = mask_face.per_w[axis];
        const auto beyond = [&](const glm::dvec3& p, double side) {
            const double bound = side > 0.0 ? mask_face.high[axis] : -mask_face.low[axis];
            return face.orthographic ? side * p[axis] - bound - reach * (mask_w(face, p.z) - w_farthest)
                                     : side * p[axis] - reach - (bound - reach * w_farthest) * p.z;
        };
        kept.keep_below(beyond(a_ls, 1.0), beyond(b_ls, 1.0));
        kept.keep_below(beyond(a_ls, -1.0), beyond(b_ls, -1.0));
    }
}

}  // namespace

double mask_w(const MapFace& face, double z_ls) noexcept {
    return face.orthographic ? face.far_m - z_ls : 1.0 / z_ls;
}

bool add_mask_edge(const MaskFace& mask_face, int size_px, const glm::dvec3& a_ls, const glm::dvec3& b_ls,
                   std::vector<gpu::MaskEdge>& out) {
    const MapFace& face = mask_face.face;
    const double nearest_m = mask_face.nearest_m;
    Part kept;
    kept.keep_below(a_ls.z - face.farthest_m, b_ls.z - face.farthest_m);
    const bool whole = face.orthographic || std::min(a_ls.z, b_ls.z) >= nearest_m;
    if (!whole) {
        kept.keep_below(nearest_m - a_ls.z, nearest_m - b_ls.z);
    }
    keep_in_hull(mask_face, a_ls, b_ls, kept);
    if (kept.empty()) {
        return whole;
    }
    const glm::dvec2 per_texel = static_cast<double>(size_px) / (face.high - face.low);
    const auto project = [&](const glm::dvec3& p_ls) {
        const double z = face.orthographic ? p_ls.z : std::max(p_ls.z, nearest_m);
        const glm::dvec2 image = face.orthographic ? glm::dvec2{p_ls} : glm::dvec2{p_ls} / z;
        return MapPoint{(image - face.low) * per_texel, mask_w(face, z)};
    };
    const MapPoint a = project(at(a_ls, b_ls, kept.from));
    const MapPoint b = project(at(a_ls, b_ls, kept.to));

    const double size = size_px;
    Part inside;
    for (int axis = 0; axis < 2; ++axis) {
        inside.keep_below(-kBeyond - a[axis], -kBeyond - b[axis]);
        inside.keep_below(a[axis] - size - kBeyond, b[axis] - size - kBeyond);
    }
    if (!inside.empty()) {
        out.push_back(record(at(a, b, inside.from), at(a, b, inside.to), true));
    }
    for (int axis = 0; axis < 2; ++axis) {
        const int other = 1 - axis;
        for (const bool high : {false, true}) {
            Part outside;
            if (high) {
                outside.keep_below(size - a[axis], size - b[axis]);
            } else {
                outside.keep_below(a[axis], b[axis]);
            }
            if (outside.empty()) {
                continue;
            }
            MapPoint p = at(a, b, outside.from);
            MapPoint q = at(a, b, outside.to);
            p[axis] = q[axis] = high ? size - 0.5 : 0.5;
            p[other] = std::clamp(p[other], 0.0, size);
            q[other] = std::clamp(q[other], 0.0, size);
            p.z = q.z = std::max(p.z, q.z);
            out.push_back(record(p, q, false));
        }
    }
    return whole;
}

bool passes_close(const MaskFace& mask_face, const glm::dvec3& a_ls, const glm::dvec3& b_ls) noexcept {
    Part kept;
    kept.keep_below(-a_ls.z, -b_ls.z);
    kept.keep_below(a_ls.z - mask_face.nearest_m, b_ls.z - mask_face.nearest_m);
    keep_in_hull(mask_face, a_ls, b_ls, kept);
    return !kept.empty();
}

}  // namespace penumbra
