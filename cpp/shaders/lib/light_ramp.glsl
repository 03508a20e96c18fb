// Visible fraction of a disc that a straight edge cuts: u is the distance of the receiver from the hard edge over the
// half width of the penumbra, -1 .. 1, positive on the lit side. [D: penumbra-maps 3.2]
float disc_fraction(float u) {
    float x = clamp(u, -1.0, 1.0);
    return clamp(0.5 + (x * sqrt(max(0.0, 1.0 - x * x)) + asin(x)) * 0.31830988618, 0.0, 1.0);
}
