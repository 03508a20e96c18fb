// The fuzzer's corpus as an ordinary test: seeds made by make_corpus.py, and every finding under its own name.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::vector<std::filesystem::path> corpus() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator{PENUMBRA_FUZZ_CORPUS}) {
        files.push_back(entry.path());
    }
    std::ranges::sort(files);
    return files;
}

std::vector<std::uint8_t> content(const std::filesystem::path& path) {
    std::ifstream file{path, std::ios::binary};
    return {std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{}};
}

TEST(SceneBorder, TakesOrRefusesEverySceneOfTheCorpus) {
    ASSERT_FALSE(corpus().empty());
    for (const auto& path : corpus()) {
        const std::vector<std::uint8_t> bytes = content(path);
        EXPECT_NO_THROW(LLVMFuzzerTestOneInput(bytes.data(), bytes.size())) << path.filename();
    }
}

TEST(SceneBorder, TakesOrRefusesWhatIsLeftOfAScene) {
    std::mt19937 random{1};
    for (const auto& path : corpus()) {
        const std::vector<std::uint8_t> whole = content(path);
        for (int round = 0; round < 40; ++round) {
            std::vector<std::uint8_t> bytes = whole;
            bytes.resize(whole.size() - random() % (whole.size() + 1));
            for (int i = 0; i < 3 && !bytes.empty(); ++i) {
                bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
            }
            EXPECT_NO_THROW(LLVMFuzzerTestOneInput(bytes.data(), bytes.size())) << path.filename() << ' ' << round;
        }
    }
}

}  // namespace
