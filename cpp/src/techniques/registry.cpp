#include <algorithm>
#include <functional>

#include "penumbra/error.h"
#include "penumbra/technique.h"
#include "techniques/hybrid/hybrid.h"
#include "techniques/light_samples/light_samples.h"
#include "techniques/linear_light_maps/linear_light_maps.h"
#include "techniques/masked_rays/masked_rays.h"
#include "techniques/pcf/pcf.h"
#include "techniques/penumbra_maps/penumbra_maps.h"
#include "techniques/plateaus/plateaus.h"
#include "techniques/ray_traced/ray_traced.h"
#include "techniques/shadow_map/shadow_map.h"
#include "techniques/shadow_volume/shadow_volume.h"
#include "techniques/smoothies/smoothies.h"

namespace penumbra {

namespace {

struct Entry {
    const TechniqueInfo& info;
    std::function<std::unique_ptr<Technique>(const Settings&)> make;
};

template <class T>
Entry entry() {
    return {T::description(), [](const Settings& settings) { return std::make_unique<T>(settings); }};
}

/// In the order users see them. A new technique is one line here and one folder.
const std::vector<Entry>& entries() {
    static const std::vector<Entry> table{
        entry<ShadowMap>(),    entry<ShadowVolume>(), entry<Hybrid>(),     entry<Pcf>(),
        entry<Smoothies>(),    entry<PenumbraMaps>(), entry<Plateaus>(),   entry<LinearLightMaps>(),
        entry<LightSamples>(), entry<RayTraced>(),    entry<MaskedRays>(),
    };
    return table;
}

}  // namespace

const std::vector<TechniqueInfo>& techniques() {
    static const std::vector<TechniqueInfo> infos = [] {
        std::vector<TechniqueInfo> all;
        for (const Entry& e : entries()) {
            all.push_back(e.info);
        }
        return all;
    }();
    return infos;
}

std::unique_ptr<Technique> make_technique(std::string_view id, const Settings& settings) {
    std::string known;
    for (const Entry& e : entries()) {
        if (e.info.id == id) {
            return e.make(complete(e.info.id, e.info.settings, settings));
        }
        known += (known.empty() ? "" : ", ") + e.info.id;
    }
    throw InvalidSettings("there is no technique \"" + std::string{id} + "\"; choose one of " + known);
}

}  // namespace penumbra
