#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace penumbra {

/// atan(x) / x - 1 as a function of x^2 > -1, for negative x^2 by the same power series, which is atanh(y) / y - 1
/// with y^2 = -x^2. Without cancellation around 0.
/// @param one_plus_x2 1 + x2, for callers who know it without cancellation
[[nodiscard]] inline double atan_ratio_less_one(double x2, double one_plus_x2) noexcept {
    if (x2 > 0.02) {
        const double x = std::sqrt(x2);
        return std::atan(x) / x - 1.0;
    }
    if (x2 < -0.02) {
        const double y = std::sqrt(-x2);
        return std::log((1.0 + y) / std::sqrt(one_plus_x2)) / y - 1.0;
    }
    double sum = 0.0;
    for (int k = 9; k >= 1; --k) {  // the tenth term is below 0.02^10 / 21
        sum = -x2 * (1.0 / (2 * k + 1) + sum);
    }
    return sum;
}

/// Lambert's contour formula: the irradiance per unit radiance of a polygon is the sum over its edges a -> b of
/// angle(a, b) n . unit(a x b) / 2, all seen from the receiver [Lambert1760]. As written it loses all digits when the
/// light is small or far: each term is of the order of its angle d, the sum of the order of d^2. Around any fixed
/// direction c the terms n . (c x (b - a)) / |c|^2 sum to zero over a closed contour, so leaving them out changes
/// nothing but makes every term of the order of d^2; that is done for contours that subtend little.
class Contour {
public:
    /// @param towards_centre from the receiver to a point in the middle of the contour
    /// @param normal unit normal of the receiver
    /// @param radius largest distance of the contour from that point
    Contour(const glm::dvec3& towards_centre, const glm::dvec3& normal, double radius) noexcept
        : centre_{towards_centre},
          normal_{normal},
          centre2_{glm::dot(towards_centre, towards_centre)},
          small_{radius * radius < 0.04 * centre2_} {}

    /// True if the constant terms are left out: then whoever mixes in terms of his own must leave them out too.
    [[nodiscard]] bool leaves_out_constant() const noexcept { return small_; }

    /// Contribution of a straight edge, its ends given as offsets from the centre. Positive when the contour runs
    /// counter-clockwise about the direction away from the receiver.
    [[nodiscard]] double edge(const glm::dvec3& from_offset, const glm::dvec3& to_offset) const noexcept {
        const glm::dvec3 a = centre_ + from_offset;
        const glm::dvec3 along = to_offset - from_offset;
        const glm::dvec3 moment = glm::cross(a, along);
        if (!small_) {
            const double sine = glm::length(moment);
            if (!(sine > 0.0)) {
                return 0.0;  // the edge points at the receiver
            }
            const double cosine = glm::dot(a, centre_ + to_offset);
            return 0.5 * glm::dot(normal_, moment) / sine * std::atan2(sine, cosine);
        }
        // integral = I / (a . b) with I = atan(x) / x, x = |a x b| / (a . b); all differences are taken before they
        // cancel: integral - 1 / |c|^2 is computed from the offsets.
        const double offset_dot = glm::dot(centre_, from_offset + to_offset) + glm::dot(from_offset, to_offset);
        const double cosine = centre2_ + offset_dot;
        const double x2 = glm::dot(moment, moment) / (cosine * cosine);
        const double less = atan_ratio_less_one(x2, 1.0 + x2);
        const double integral = (1.0 + less) / cosine;
        const double difference = (less - offset_dot / centre2_) / cosine;
        return 0.5 * (glm::dot(normal_, glm::cross(from_offset, along)) * integral +
                      glm::dot(normal_, glm::cross(centre_, along)) * difference);
    }

private:
    glm::dvec3 centre_;
    glm::dvec3 normal_;
    double centre2_;
    bool small_;
};

}  // namespace penumbra
