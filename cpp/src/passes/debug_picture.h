#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>

#include "gl/framebuffer.h"
#include "penumbra/technique.h"

namespace penumbra {

class CentreMap;
class Frame;
class SilhouettePass;
class TextureImage;

/// Pictures of a technique's inside (Technique::debug_image). Slow and for people: everything is read back.

/// The camera's view in grey, lit from the eye; `draw` adds to it, blending off and no depth test.
[[nodiscard]] DebugImage view_picture(const Frame& frame, std::string caption,
                                      const std::function<void(RenderTarget&)>& draw);

/// The map's faces side by side, nearest surfaces brightest; `draw` adds to one face. A program that includes
/// lib/map_space.glsl finds its block bound.
[[nodiscard]] DebugImage map_picture(const Frame& frame, CentreMap& map, std::string caption,
                                     const std::function<void(int face, RenderTarget&)>& draw);

/// The view that every technique with a CentreMap has.
[[nodiscard]] DebugView depth_map_view();
[[nodiscard]] DebugImage depth_map_picture(const Frame& frame, CentreMap& map);

/// One component of a float texture, its layers side by side: `low` black, `high` white, beyond them clipped;
/// not finite: magenta. The caption gets the range.
[[nodiscard]] DebugImage texture_picture(const TextureImage& texture, int component, float low, float high,
                                         std::string caption);

/// Silhouettes as lines. In the view, what lies behind a surface is drawn faintly.
void draw_silhouettes_in_view(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes,
                              const glm::dvec3& origin_ws, const glm::vec3& colour);
void draw_silhouettes_in_map(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes, CentreMap& map, int face,
                             const glm::vec3& colour);

}  // namespace penumbra
