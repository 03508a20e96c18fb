#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <unordered_map>

#include "penumbra/scene.h"

namespace penumbra {

/// validate(Scene&) for one scene after another: a mesh that was in the one before is not looked through again, so
/// that moving one object of a large scene costs no more than the list of objects.
class SceneValidator {
public:
    /// @throws InvalidScene as validate(Scene&) does; what is known of meshes then stays as it was
    void validate(Scene& scene);

private:
    struct Known {
        std::shared_ptr<const Mesh> mesh;  ///< kept, so that a pointer names the same mesh as before
        glm::dvec3 reach{0.0};
    };
    std::unordered_map<const Mesh*, Known> known_;  ///< of the scene before
};

}  // namespace penumbra
