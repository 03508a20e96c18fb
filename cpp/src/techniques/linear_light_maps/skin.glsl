// One skin: the span of a row that joins a caster's edge in one view to what lies behind it, as the neighbour sees it.
// Depths are the stored ones; position and depth are linear along it [linear-light-soft-shadow-maps 2.5].
struct Skin {
    float caster_texel;    // continuous texel coordinate along the row
    float receiver_texel;
    float caster_depth, receiver_depth;
};
