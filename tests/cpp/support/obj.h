#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "penumbra/scene.h"

namespace penumbra {

/// Positions and faces of a well-known model, or nullptr where it is missing: in the folder that the environment
/// variable PENUMBRA_MODELS names, else in ../shared/data beside the checkout. `file` as in "spot.obj"; polygons become
/// fans.
inline std::shared_ptr<Mesh> read_model(const std::string& file) {
    const char* folder = std::getenv("PENUMBRA_MODELS");
    const std::filesystem::path root = folder != nullptr
                                           ? std::filesystem::path{folder}
                                           : std::filesystem::path{PENUMBRA_SOURCE_DIR} / "../shared/data";
    std::ifstream in{root / file};
    if (!in) {
        return nullptr;
    }
    auto mesh = std::make_shared<Mesh>();
    mesh->name = file;
    for (std::string line; std::getline(in, line);) {
        std::istringstream words{line};
        std::string key;
        words >> key;
        if (key == "v") {
            glm::vec3 p;
            words >> p.x >> p.y >> p.z;
            mesh->positions_local.push_back(p);
        } else if (key == "f") {
            std::vector<std::uint32_t> corners;
            for (std::string corner; words >> corner;) {
                const long index = std::stol(corner);  // stops at the slash
                corners.push_back(static_cast<std::uint32_t>(
                    index > 0 ? index - 1 : static_cast<long>(mesh->positions_local.size()) + index));
            }
            for (std::size_t k = 2; k < corners.size(); ++k) {
                mesh->triangles.emplace_back(corners[0], corners[k - 1], corners[k]);
            }
        }
    }
    return mesh;
}

}  // namespace penumbra
