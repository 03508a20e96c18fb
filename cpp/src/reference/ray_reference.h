#pragma once

#include <span>

#include "penumbra/control.h"
#include "penumbra/reference.h"
#include "penumbra/scene.h"
#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

/// V and the irradiance ratio of one light at every pixel, to a standard error per pixel.
///
/// Two phases. A pilot of 72 rays per pixel guesses how the error falls there, from the pixel and those around it, and
/// so sets the pixel's number of rays; its rays are then forgotten. The second phase casts that many new rays,
/// whatever they find, so `area` is unbiased: nothing that is reported decided how much is reported.
///
/// The light is cut into strata with two independent samples each. The difference within a pair gives the variance of
/// the mean without bias, sum over strata of (a - b)^2 / 4 / strata^2, and costs only 2^(1/4) in error against one
/// sample per stratum. Many strata are cut by a shadow's edge, so the estimate of the error is itself steady, which
/// that of a few repeated images is not.
///
/// A pixel's count of differing pairs is some 10 in a penumbra and so scatters by a third, and errors beyond 4 of the
/// standard errors told come from counts that are too small. So the larger of the count and its neighbourhood's mean is
/// told. The RMS of the error over the one told is then 0.90 to 0.96; where V changes within a pixel or two more is
/// told than there is.
///
/// Half a differing pair is added to those found: a feature smaller than one stratum may have been missed, and the
/// largest standard deviation it can cause is 0.71 / rays, as if half a pair had differed. So no pixel tells an error
/// of 0, and the least number of rays of every pixel, lit ones too, is 0.71 / standard_error (354 for 0.002). A pixel
/// that looks fully lit with 1 - V = d left slips through with probability (1 - d)^rays at most, that is 0.49 for d =
/// standard_error and 0.001 for d = 10 standard_error. For the irradiance what was missed may weigh more than the mean:
/// half a pair of the weights' mean square is added. For line lights, where a single pair decides, the error told is
/// up to 1.6 times too high.
///
/// `irradiance` is the ratio of two sums over the same rays. Its bias is of second order (the product of both sums'
/// relative errors, below 1e-5 at the defaults) and it is exactly 1 where nothing blocks.
///
/// `reached` is false if the pilot asked for more than max_rays_per_pixel somewhere. The error told
/// scatters about a predicted one, which has some rays in hand: more than nine in ten penumbra pixels end below the
/// one asked for, and the RMS over a penumbra is some 20 % below it.
///
/// @param scene_rays  of `scene`
/// @throws InvalidSettings for a standard error that is not in (0, 1) or fewer than 2 rays; Cancelled
[[nodiscard]] Reference trace_reference(const RayScene& scene_rays, const Scene& scene, const View& view,
                                        const Light& light, const ReferenceOptions& options, Control& control);

}  // namespace penumbra
