// The sheet of an edge: the plane through it that touches the light on the outer side. Needs lib/edge_space.glsl and
// light_base.glsl.

struct Tangent {
    bool exists;  // else one end's cone contains the other's [P 2.4.9]
    vec2 at_a, at_b;
};

// a and b as (p, w), unit lengths; the outer side is on the left of a -> b.
Tangent tangent_of(vec3 a, vec3 b) {
    Tangent found;
    vec2 along = b.xy - a.xy;
    float len = length(along);
    vec2 e = along / max(len, 1e-30);
    vec2 outer = vec2(-e.y, e.x);
    float dw = a.z - b.z;
#if CONE_BASE == 0
    // Unit disc: both circles have the same normal n, cos beta = dw / len.
    float cosine = dw / max(len, 1e-30);
    found.exists = len > 1e-9 && abs(cosine) < 1.0;
    found.at_a = cosine * e + sqrt(max(0.0, 1.0 - cosine * cosine)) * outer;
    found.at_b = found.at_a;
#elif CONE_BASE == 1
    // The corner q whose line towards the point where the edge meets the light's plane has all others on one side.
    found.exists = false;
    found.at_a = found.at_b = vec2(0.0);
    for (int k = 0; k < LIGHT_CORNERS; ++k) {
        vec2 q = light_corner[k].xy;
        vec2 line = -along - q * dw;
        vec2 m = vec2(-line.y, line.x);
        m = dot(m, outer) < 0.0 ? -m : m;
        float least = 0.0;
        for (int j = 0; j < LIGHT_CORNERS; ++j) {
            least = min(least, dot(m, light_corner[j].xy - q));
        }
        if (least >= -1e-6 * length(m) * light_reach && !found.exists) {
            found.exists = len > 1e-9;
            found.at_a = found.at_b = -q;
        }
    }
#else
    // Sphere: the plane through the edge that touches it in T; displacements towards the images of T.
#if MAP_ORTHOGRAPHIC
    found.exists = false;
    found.at_a = found.at_b = vec2(0.0);
#else
    vec3 a_ls = vec3(a.xy, 1.0) / a.z, b_ls = vec3(b.xy, 1.0) / b.z;
    vec3 d = b_ls - a_ls;
    d /= max(length(d), 1e-30);
    vec3 foot = a_ls - d * dot(a_ls, d);
    float distance = length(foot);
    float sine = light_reach / max(distance, 1e-30);
    found.exists = len > 1e-9 && sine < 1.0;
    vec3 f = foot / max(distance, 1e-30);
    vec3 side = cross(d, f);
    // Of the two planes the one whose point T lies on the inner side: the shadow's rim is thrown outwards.
    vec2 side_ip = side.xy - a.xy * side.z;
    side = dot(side_ip, outer) > 0.0 ? -side : side;
    vec3 touch = light_reach * (sine * f + sqrt(max(0.0, 1.0 - sine * sine)) * side);
    // Where the line from T through the end meets the plane z_ls = 0.
    vec3 qa = touch - (a_ls - touch) * touch.z / (a_ls.z - touch.z);
    vec3 qb = touch - (b_ls - touch) * touch.z / (b_ls.z - touch.z);
    found.at_a = -qa.xy;
    found.at_b = -qb.xy;
#endif
#endif
    return found;
}
