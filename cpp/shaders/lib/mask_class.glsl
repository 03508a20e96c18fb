// Classes of the penumbra mask (passes/penumbra_mask.h), as its texture of bytes between 0 and 1 holds them.
const float PENUMBRA_MASK_MAYBE = 0.0;
const float PENUMBRA_MASK_LIT = 1.0 / 255.0;
const float PENUMBRA_MASK_UMBRA = 2.0 / 255.0;
