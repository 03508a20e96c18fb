// From the place between a silhouette and the rim of its penumbra to the intensity that the map keeps.
// RAMP: 0 linear in depth along the light ray (published), 1 linear in the image plane, 2 true distance from tilted
// edges. FALLOFF: 0 smoothstep, 1 linear, 2 the area of the light's shape. SIDES_BOTH: V = 1/2 at the hard edge.

uniform float contact;  // least gap between edge and surface; perspective: times w of the edge

bool too_close(float w_edge, float w_surface) {
#if MAP_ORTHOGRAPHIC
    return !(w_edge - w_surface > contact);
#else
    return !(w_edge - w_surface > contact * w_edge);
#endif
}

// t: 0 at the edge .. 1 at the rim.
float fall_off(float t) {
#if FALLOFF == 0
#if SIDES_BOTH
    t = 0.5 + 0.5 * t;
#endif
    return t * t * (3.0 - 2.0 * t);
#elif FALLOFF == 1
#if SIDES_BOTH
    t = 0.5 + 0.5 * t;
#endif
    return t;
#elif SIDES_BOTH
    return disc_fraction(t);
#else
    return 2.0 * disc_fraction(t) - 1.0;
#endif
}
