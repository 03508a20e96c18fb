// Unshadowed irradiance of one light: the float32 twin of geometry/irradiance.h, which says what is computed, in which
// units and what the degenerate cases mean. Written in the common subset of GLSL and of C++ with GLM, so that a test
// runs the very same text on the CPU (tests/cpp/geometry/irradiance_glsl_test.cpp).
//
//     vec3 E = light.emission_form.rgb * irradiance_per_radiance(light, p_cr, n) * spot_attenuation(light, p_cr);

#include "shared/light.h"

const float kPenumbraPi = 3.14159265358979;

// atan(x) / x - 1 as a function of x2 = x^2 > -1 (negative: atanh), without cancellation around 0.
float penumbra_atan_ratio_less_one(float x2, float one_plus_x2) {
    if (x2 > 0.1) {
        float x = sqrt(x2);
        return atan(x) / x - 1.0;
    }
    if (x2 < -0.1) {
        float y = sqrt(-x2);
        return log((1.0 + y) / sqrt(one_plus_x2)) / y - 1.0;
    }
    return -x2 * (1.0 / 3.0 - x2 * (1.0 / 5.0 - x2 * (1.0 / 7.0 - x2 * (1.0 / 9.0 - x2 * (1.0 / 11.0 - x2 / 13.0)))));
}

// Lambert's contour over one straight edge between centre + from and centre + to, seen from the receiver.
// small_contour: leave out the constant term, as Contour in geometry/contour.h does.
float penumbra_contour_edge(vec3 centre, vec3 n, bool small_contour, vec3 from, vec3 to) {
    vec3 a = centre + from;
    vec3 along = to - from;
    vec3 moment = cross(a, along);
    if (!small_contour) {
        float sine = length(moment);
        if (!(sine > 0.0)) {
            return 0.0;
        }
        return 0.5 * dot(n, moment) / sine * atan(sine, dot(a, centre + to));
    }
    float centre2 = dot(centre, centre);
    float offset_dot = dot(centre, from + to) + dot(from, to);
    float cosine = centre2 + offset_dot;
    float x2 = dot(moment, moment) / (cosine * cosine);
    float less = penumbra_atan_ratio_less_one(x2, 1.0 + x2);
    return 0.5 * (dot(n, cross(from, along)) * ((1.0 + less) / cosine) +
                  dot(n, cross(centre, along)) * ((less - offset_dot / centre2) / cosine));
}

// Part above the horizon of the cone x = a cos t, y = b sin t, z = 1, where the horizon n cuts it.
float penumbra_cut_cone(float a, float b, vec3 n) {
    float reach = length(vec2(a * n.x, b * n.y));
    float middle = atan(b * n.y, a * n.x);
    float width = acos(clamp(-n.z / reach, -1.0, 1.0));
    float a2 = a * a;
    float b2 = b * b;
    float big_a = 1.0 + a2;
    float big_b = 1.0 + b2;
    float root = sqrt(big_b / big_a);
    float root_less_one = (b2 - a2) / (big_a * (root + 1.0));
    float radius = max(a, b);
    bool small_cone = radius * radius < 0.04;
    float integral_1 = 2.0 * width;
    float integral_cos = 0.0;
    float integral_sin = 0.0;
    vec3 first = vec3(0.0);
    vec3 last = vec3(0.0);
    for (int k = 0; k < 2; ++k) {
        float direction = k == 0 ? -1.0 : 1.0;
        float t = middle + direction * width;
        float s = sin(t);
        float c = cos(t);
        float r2 = 1.0 + a2 * c * c + b2 * s * s;
        integral_1 += direction * atan(root_less_one * s * c / (c * c + root * s * s));
        float less_s = penumbra_atan_ratio_less_one((b2 - a2) * s * s / big_a, r2 / big_a);
        float less_c = penumbra_atan_ratio_less_one((a2 - b2) * c * c / big_b, r2 / big_b);
        integral_cos += direction * s * (small_cone ? a2 - less_s : 1.0 + less_s) / big_a;
        integral_sin -= direction * c * (small_cone ? b2 - less_c : 1.0 + less_c) / big_b;
        first = last;
        last = vec3(a * c, b * s, 0.0);
    }
    float arc = n.z * (a / sqrt(big_a)) * (b / sqrt(big_b)) * integral_1 +
                (small_cone ? 1.0 : -1.0) * (n.x * b * integral_cos + n.y * a * integral_sin);
    if (small_cone) {
        return max(0.0, 0.5 * arc + penumbra_contour_edge(vec3(0.0, 0.0, 1.0), n, true, last, first));
    }
    // The chord lies in the horizon: its angle is all it takes. In units of the radius, so that squares stay finite.
    last = (last + vec3(0.0, 0.0, 1.0)) / (1.0 + radius);
    first = (first + vec3(0.0, 0.0, 1.0)) / (1.0 + radius);
    return max(0.0, 0.5 * (arc + atan(length(cross(last, first)), dot(last, first))));
}

float penumbra_cone_irradiance(float sine, float cosine, vec3 axis, vec3 n) {
    float up = dot(axis, n);
    if (up >= sine) {
        return kPenumbraPi * sine * sine * up;
    }
    if (up <= -sine || sine <= 0.0) {
        return 0.0;
    }
    float tangent = sine / max(cosine, 1e-7);
    float across = length(cross(axis, n));
    if (abs(up) >= tangent * across) {
        return up > 0.0 ? kPenumbraPi * sine * sine * up : 0.0;
    }
    return penumbra_cut_cone(tangent, tangent, vec3(across, 0.0, up));
}

float penumbra_equal_axes_root(float axis2, float x2, float y2, float h2) {
    float p = x2 + y2 + h2 - axis2;
    float q = sqrt(p * p + 4.0 * axis2 * h2);
    return p >= 0.0 ? 0.5 * (p + q) : 2.0 * axis2 * h2 / (q - p);
}

// Largest root of x2/(a2 + m) + y2/(b2 + m) + h2/m = 1, see confocal_root in geometry/irradiance.cpp.
float penumbra_confocal_root(float a2, float b2, float x2, float y2, float h2) {
    float low = penumbra_equal_axes_root(max(a2, b2), x2, y2, h2);
    float high = max(low, penumbra_equal_axes_root(min(a2, b2), x2, y2, h2));
    float m = low;
    for (int i = 0; i < 24 && high > low; ++i) {
        float fa = x2 / (a2 + m);
        float fb = y2 / (b2 + m);
        float fh = h2 / m;
        float f = fa + fb + fh - 1.0;
        if (f > 0.0) {
            low = m;
        } else {
            high = m;
        }
        float slope_m = fa * m / (a2 + m) + fb * m / (b2 + m) + fh;
        float next = slope_m > f ? m * slope_m / (slope_m - f) : high;
        if (!(next > low && next < high)) {
            next = high > 4.0 * low ? sqrt(low) * sqrt(high) : 0.5 * (low + high);
        }
        if (abs(next - m) <= 1e-7 * m) {
            break;
        }
        m = next;
    }
    return m;
}

// Ellipse with perpendicular half axes u and v, on either side of it.
float penumbra_ellipse_irradiance(vec3 towards_centre, vec3 half_u, vec3 half_v, vec3 n) {
    // In units of the distance, so that no power of a length leaves float32.
    float unit = 1.0 / length(towards_centre);
    vec3 c = towards_centre * unit;
    vec3 u = half_u * unit;
    vec3 v = half_v * unit;
    float a = length(u);
    float b = length(v);
    vec3 axis_u = u / a;
    vec3 axis_v = v / b;
    vec3 axis_w = cross(axis_u, axis_v);
    float h = dot(axis_w, c);
    if (h < 0.0) {
        axis_w = -axis_w;
        h = -h;
    }
    float middle = dot(n, c);
    float reach = length(vec2(dot(n, u), dot(n, v)));
    if (!(h > 0.0) || middle <= -reach) {
        return 0.0;
    }
    float x = dot(axis_u, c);
    float y = dot(axis_v, c);
    float m = penumbra_confocal_root(a * a, b * b, x * x, y * y, h * h);
    float root_m = sqrt(m);
    // The quadric's normal times m: no term overflows as h and m vanish together.
    vec3 along = axis_u * (x * m / (a * a + m)) + axis_v * (y * m / (b * b + m)) + axis_w * h;
    float along_length = length(along);
    vec3 z = along / along_length;
    float whole = kPenumbraPi * (a / sqrt(a * a + m)) * (b / sqrt(b * b + m)) * (h / along_length);
    if (middle >= reach) {
        return max(0.0, whole * dot(n, z));
    }
    float handed = z.z < 0.0 ? -1.0 : 1.0;
    float p = -1.0 / (handed + z.z);
    float q = z.x * z.y * p;
    vec3 e1 = vec3(1.0 + handed * z.x * z.x * p, handed * q, -handed * z.x);
    vec3 e2 = vec3(q, handed + z.y * z.y * p, -z.y);
    vec3 d1 = vec3(dot(u, e1), dot(v, e1), dot(c, e1));
    vec3 d2 = vec3(dot(u, e2), dot(v, e2), dot(c, e2));
    float d11 = d1.x * d1.x + d1.y * d1.y - d1.z * d1.z;
    float d12 = d1.x * d2.x + d1.y * d2.y - d1.z * d2.z;
    float d22 = d2.x * d2.x + d2.y * d2.y - d2.z * d2.z;
    float spread = length(vec2(d11 - d22, 2.0 * d12));
    float turn = spread > 0.0 ? 0.5 * atan(2.0 * d12, d11 - d22) : 0.0;
    vec3 x_axis = cos(turn) * e1 + sin(turn) * e2;
    vec3 y_axis = cos(turn) * e2 - sin(turn) * e1;
    float largest = 0.5 * (d11 + d22 + spread);
    if (!(largest > 0.0)) {
        return 0.0;
    }
    float wide = sqrt(largest) / root_m;
    float narrow = (a / root_m) * (b / root_m) * (h / sqrt(largest));
    vec3 local = vec3(dot(n, x_axis), dot(n, y_axis), dot(n, z));
    float edge = length(vec2(wide * local.x, narrow * local.y));
    if (local.z >= edge) {
        return max(0.0, whole * local.z);
    }
    return local.z <= -edge ? 0.0 : penumbra_cut_cone(wide, narrow, local);
}

float penumbra_polygon_irradiance(LightBlock light, vec3 towards_centre, vec3 n) {
    int count = int(light.direction.w + 0.5);
    float radius2 = 0.0;
    for (int i = 0; i < count; ++i) {
        vec3 offset = vec3(light.corner[i]);
        radius2 = max(radius2, dot(offset, offset));
    }
    bool small_contour = radius2 < 0.04 * dot(towards_centre, towards_centre);
    float height = dot(n, towards_centre);
    float sum = 0.0;
    bool open = false;
    vec3 left = vec3(0.0);
    vec3 entered = vec3(0.0);
    for (int i = 0; i < count; ++i) {
        vec3 from = vec3(light.corner[i]);
        vec3 to = vec3(light.corner[i + 1 < count ? i + 1 : 0]);
        float at_from = height + dot(n, from);
        float at_to = height + dot(n, to);
        if (at_from >= 0.0 && at_to >= 0.0) {
            sum += penumbra_contour_edge(towards_centre, n, small_contour, from, to);
        } else if (at_from >= 0.0 || at_to >= 0.0) {
            vec3 cut = from + (to - from) * (at_from / (at_from - at_to));
            open = true;
            if (at_from >= 0.0) {
                sum += penumbra_contour_edge(towards_centre, n, small_contour, from, cut);
                left = cut;
            } else {
                sum += penumbra_contour_edge(towards_centre, n, small_contour, cut, to);
                entered = cut;
            }
        }
    }
    if (open) {
        sum += penumbra_contour_edge(towards_centre, n, small_contour, left, entered);
    }
    return max(0.0, -sum);  // the corners run clockwise about the direction away from the receiver
}

// facing: unit normal of a flat strip, or 0 for a cylinder.
float penumbra_line_irradiance(vec3 towards_centre, vec3 half_line, vec3 n, vec3 facing) {
    float middle = dot(n, towards_centre);
    float slope = dot(n, half_line);
    float low = -1.0;
    float high = 1.0;
    if (middle < abs(slope)) {
        if (middle <= -abs(slope)) {
            return 0.0;
        }
        if (slope > 0.0) {
            low = -middle / slope;
        } else {
            high = -middle / slope;
        }
    }
    float half_length = length(half_line);
    vec3 along = half_line / half_length;
    float foot = dot(along, towards_centre);
    vec3 perpendicular = towards_centre - foot * along;
    float h = length(perpendicular);
    float l0 = foot + low * half_length;
    float l1 = foot + high * half_length;
    float r0 = length(vec2(h, l0));
    float r1 = length(vec2(h, l1));
    if (!(h > 1e-6 * length(towards_centre))) {
        return 0.0;
    }
    float line_length = (high - low) * half_length;
    float angle = atan(h * line_length, h * h + l0 * l1);
    float per_r = line_length / (r0 * r1);
    float across = dot(n, perpendicular) / h;
    float sum = 0.5 * (across * (angle / h + per_r * ((h / r0) * (h / r1) - (l0 / r0) * (l1 / r1))) +
                       dot(n, along) * per_r * (h / r0) * ((l0 + l1) / r1));
    float shine = dot(facing, facing) > 0.0 ? -dot(facing, perpendicular) / h : 1.0;
    return max(0.0, sum) * max(0.0, shine);
}

// Irradiance per unit of light.emission_form.rgb, without a spot's cone; finite and >= 0 everywhere.
// p_cr: receiver relative to the eye, metres; n: its unit normal.
float irradiance_per_radiance(LightBlock light, vec3 p_cr, vec3 n) {
    int form = int(light.emission_form.w + 0.5);
    vec3 direction = vec3(light.direction);
    if (form == PENUMBRA_LIGHT_DIRECTION) {
        return max(0.0, -dot(n, direction));
    }
    if (form == PENUMBRA_LIGHT_SUN) {
        return penumbra_cone_irradiance(light.half_u.w, light.half_v.w, -direction, n);
    }
    vec3 to = vec3(light.centre_cr) - p_cr;
    float distance = length(to);
    if (form == PENUMBRA_LIGHT_NONE || !(distance > 0.0)) {
        return form == PENUMBRA_LIGHT_SPHERE ? kPenumbraPi : 0.0;
    }
    vec3 towards = to / distance;
    if (form == PENUMBRA_LIGHT_POINT) {
        return max(0.0, dot(n, towards)) / distance / distance;
    }
    if (form == PENUMBRA_LIGHT_SPHERE) {
        float radius = light.centre_cr.w;
        if (distance <= radius) {
            return kPenumbraPi;
        }
        float cosine = sqrt(((distance - radius) / distance) * ((distance + radius) / distance));
        return penumbra_cone_irradiance(radius / distance, cosine, towards, n);
    }
    if (form == PENUMBRA_LIGHT_LINE) {
        return penumbra_line_irradiance(to, vec3(light.half_u), n, vec3(0.0));
    }
    // The rest shines to one side only.
    float shine = -dot(direction, towards);
    if (!(shine > 0.0)) {
        return 0.0;
    }
    if (form == PENUMBRA_LIGHT_FACING_POINT) {
        return max(0.0, dot(n, towards)) * shine / distance / distance;
    }
    if (form == PENUMBRA_LIGHT_FACING_LINE) {
        return penumbra_line_irradiance(to, vec3(light.half_u), n, direction);
    }
    if (form == PENUMBRA_LIGHT_ELLIPSE) {
        return penumbra_ellipse_irradiance(to, vec3(light.half_u), vec3(light.half_v), n);
    }
    return penumbra_polygon_irradiance(light, to, n);
}

// Transmission of a spot's cone, 0 .. 1; 1 for other kinds.
float spot_attenuation(LightBlock light, vec3 p_cr) {
    if (light.spot.x < -1.5) {
        return 1.0;
    }
    vec3 offset = p_cr - vec3(light.centre_cr);
    vec3 local = vec3(dot(offset, vec3(light.half_u)) / light.spot.z, dot(offset, vec3(light.half_v)) / light.spot.w,
                      dot(offset, vec3(light.direction)));
    float distance = length(local);
    if (!(distance > 0.0)) {
        return 0.0;
    }
    float inside = local.z / distance - light.spot.x;
    float soft = (1.0 - light.spot.x) * light.spot.y;
    if (inside <= 0.0 || inside >= soft) {
        return inside > 0.0 ? 1.0 : 0.0;
    }
    float t = inside / soft;
    return t * t * (3.0 - 2.0 * t);
}
