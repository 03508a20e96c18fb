#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "penumbra/renderer.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {

/// One renderer for all tests of the program: making a context takes longer than most tests.
class RendererGl : public testing::Test {
protected:
    void SetUp() override {
        setenv("PENUMBRA_EMBREE", PENUMBRA_EMBREE_PLUGIN, 0);
        if (!shared()) {
            try {
                shared() = std::make_unique<Renderer>();
            } catch (const DeviceError& error) {
                PENUMBRA_SKIP(error.what());
            }
        }
    }
    static std::unique_ptr<Renderer>& shared() {
        static std::unique_ptr<Renderer> renderer;
        return renderer;
    }
    Renderer& renderer() { return *shared(); }

    std::vector<float> visibility(const Scene& scene, const std::string& technique, const Settings& settings = {},
                                  bool keep_everything = false) {
        renderer().set_scene(scene);
        return renderer().visibility(0, {technique, settings}, keep_everything, control_).visibility;
    }
    /// Mean over the columns of a straight_edge() image, one value per x.
    static std::vector<double> profile(const std::vector<float>& image, const Camera& camera) {
        std::vector<double> values(static_cast<std::size_t>(camera.width_px), 0.0);
        for (int y = 0; y < camera.height_px; ++y) {
            for (int x = 0; x < camera.width_px; ++x) {
                values[static_cast<std::size_t>(x)] += image[static_cast<std::size_t>(y * camera.width_px + x)];
            }
        }
        for (double& value : values) {
            value /= camera.height_px;
        }
        return values;
    }
    static double rmse(const std::vector<float>& a, const std::vector<float>& b) {
        double sum = 0.0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            sum += (a[i] - b[i]) * static_cast<double>(a[i] - b[i]);
        }
        return std::sqrt(sum / static_cast<double>(a.size()));
    }
    static double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
        double largest = 0.0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            largest = std::max(largest, std::abs(static_cast<double>(a[i]) - b[i]));
        }
        return largest;
    }
    static double share_that_differs(const std::vector<float>& a, const std::vector<float>& b, double tolerance) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            count += std::abs(static_cast<double>(a[i]) - b[i]) > tolerance ? 1 : 0;
        }
        return static_cast<double>(count) / static_cast<double>(a.size());
    }
    Control control_;
};

}  // namespace penumbra
