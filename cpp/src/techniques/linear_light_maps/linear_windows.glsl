// Which of the windows around a rod a point belongs to; the rest lies too close to the rod's own line.
uniform vec3 rod_u, rod_v, rod_f;  // unit, along the rod and the first window's axes
uniform int window_towards[12];    // index of the window along f, v, -f, -v; further along u; against u; -1: none
uniform vec3 rod_reach;            // x, y places of the first and the last sample; z farthest along u, in depths

int find_window(vec3 p_rel) {
    float u = dot(p_rel, rod_u);
    float v = dot(p_rel, rod_v);
    float f = dot(p_rel, rod_f);
    float z = max(abs(f), abs(v));
    int part = abs(u) <= z ? 0 : (u > 0.0 ? 1 : 2);
    int towards = abs(f) >= abs(v) ? (f >= 0.0 ? 0 : 2) : (v >= 0.0 ? 1 : 3);
    return max(u - rod_reach.x, rod_reach.y - u) > rod_reach.z * z ? -1 : window_towards[4 * part + towards];
}
