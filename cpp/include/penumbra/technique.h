#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/light.h"
#include "penumbra/plan.h"
#include "penumbra/settings.h"

namespace penumbra {

class Frame;          // passes/frame.h: scene, view and light on the GPU, and the step clock
struct LightSummary;  // scene/summary.h: what of the scene matters to one light

/// What is known of a technique without running it.
struct TechniqueInfo {
    std::string id;           ///< "shadow_map"
    std::string title;        ///< "Hard shadow map"
    std::string paper;        ///< key in docs/references.bib
    std::string summary;      ///< one sentence
    bool randomised = false;  ///< has a "seed" setting and noise that falls with samples
    bool on_cpu = false;      ///< makes no use of OpenGL beyond the view
    std::vector<LightKind> lights;
    std::vector<SettingInfo> settings;
    std::string knob;  ///< the swept setting that trades error for time the most; empty: the technique has none
};

/// What a technique, with its settings, takes for granted. Where a scene is otherwise it is drawn all the same, and the
/// plan warns (passes/field_of_use).
struct FieldOfUse {
    bool needs_point_light = false;          ///< one point stands for the light
    bool needs_small_light = false;          ///< what the light's centre does not see is black, however wide the light
    bool needs_round_light = false;          ///< penumbrae know of a width, not of a shape
    bool needs_line_light = false;           ///< one line stands for a round light
    bool needs_clear_light = false;          ///< casters close to the light are cut off or moved away from it
    bool needs_light_above_horizon = false;  ///< what of the light lies under a receiver's own plane counts as hidden
    bool needs_float32_rays = false;         ///< distances must be told apart at the scale of the whole scene
};

/// An ordinary no: why this technique cannot serve this light, or empty for yes.
struct Verdict {
    std::string reason;
    [[nodiscard]] explicit operator bool() const noexcept { return reason.empty(); }
};

/// A picture of a technique's inside, for people.
struct DebugImage {
    int width_px = 0, height_px = 0;
    std::vector<glm::vec3> rgb;  ///< display values 0 .. 1, row 0 at the bottom
    std::string caption;         ///< one sentence: what is seen, what the colours mean
};
struct DebugView {
    std::string id;     ///< "silhouettes", "penumbra_map"
    std::string title;  ///< "Silhouettes as the light sees them"
};

/// A count or a share that a technique reports of the frame just made: tagged pixels, rays cast.
struct Statistic {
    std::string id;     ///< "tagged_share"
    std::string label;  ///< "Tagged pixels"
    std::string unit;   ///< "pixels", "rays", "share of the mask" (then 0 .. 1)
    double value = 0.0;
};

/// V of one light on a flat piece of the scene, to be laid over it as a texture.
struct BakedTexture {
    std::string name;  ///< of the surface
    int width_px = 0, height_px = 0;
    std::vector<float> visibility;           ///< row 0 at the bottom, along corners 0 -> 1
    std::array<glm::dvec3, 4> corners_ws{};  ///< of the image, at the UVs (0, 0), (1, 0), (1, 1), (0, 1)
};

/// One way to turn (scene, view, light, settings) into V per pixel: 0 umbra .. 1 lit.
///
/// All calls come from the render thread. A Technique object serves one light with one set of settings and owns the
/// maps it keeps between frames. The order is plan, prepare, update, resolve; then again resolve alone (maps are
/// kept: static frame) or update and resolve (casters or the light moved: dynamic frame).
class Technique {
public:
    virtual ~Technique() = default;
    [[nodiscard]] virtual const TechniqueInfo& info() const noexcept = 0;
    [[nodiscard]] virtual Verdict supports(const Light& light) const = 0;
    /// Decides what runs; reads numbers only, touches no GPU object.
    [[nodiscard]] virtual Plan plan(const LightSummary& summary) const = 0;
    /// What it takes for granted with its settings; by default nothing.
    [[nodiscard]] virtual FieldOfUse field_of_use() const { return {}; }
    /// Programs, buffers, maps: what a second frame does not need again.
    virtual void prepare(Frame& frame) = 0;
    /// Light space: what depends on the casters and the light.
    virtual void update(Frame& frame) = 0;
    /// View space: V at every pixel into frame.visibility().
    virtual void resolve(Frame& frame) = 0;
    [[nodiscard]] virtual std::size_t memory_bytes() const noexcept = 0;

    /// What debug_image() can draw; a view of a step that the plan leaves out is not among them.
    [[nodiscard]] virtual std::vector<DebugView> debug_views(const Plan& /*plan*/) const { return {}; }
    /// After update() and resolve(). @param id one of debug_views()
    [[nodiscard]] virtual DebugImage debug_image(Frame& /*frame*/, std::string_view /*id*/) { return {}; }
    /// Of the frame just made, after update() and resolve(); may wait for the device and may draw again to count, and
    /// is no part of any time.
    [[nodiscard]] virtual std::vector<Statistic> statistics(Frame& /*frame*/) { return {}; }
    /// The technique's own textures of V on surfaces of the scene, after update(); empty if it makes none.
    [[nodiscard]] virtual std::vector<BakedTexture> bake(Frame& /*frame*/) { return {}; }
};

/// All techniques, in the order users see them.
[[nodiscard]] const std::vector<TechniqueInfo>& techniques();
/// @throws InvalidSettings for an unknown id or bad settings; the message lists the ids.
[[nodiscard]] std::unique_ptr<Technique> make_technique(std::string_view id, const Settings& settings);

}  // namespace penumbra
