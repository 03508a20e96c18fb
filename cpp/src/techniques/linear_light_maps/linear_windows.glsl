// Which of the windows around a rod a point belongs to; the rest lies too close to the rod's own line.
uniform vec3 rod_u, rod_v, rod_f;  // unit, along the rod and the first window's axes
uniform ivec4 window_towards;      // index of the window along f, v, -f, -v; -1: none
uniform vec3 rod_reach;            // x, y places of the first and the last sample; z farthest along u, in depths

int find_window(vec3 p_rel) {
    float u = dot(p_rel, rod_u);
    float v = dot(p_rel, rod_v);
    float f = dot(p_rel, rod_f);
    bool along_f = abs(f) >= abs(v);
    int window = along_f ? (f >= 0.0 ? window_towards.x : window_towards.z)
                         : (v >= 0.0 ? window_towards.y : window_towards.w);
    float z = max(abs(f), abs(v));
    return max(u - rod_reach.x, rod_reach.y - u) > rod_reach.z * z ? -1 : window;
}
