#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// What crosses from the plugin `penumbra_embree.so` into the core: plain C data, no Embree header.
//
// Blender loads an Embree of its own into the global scope, under the same symbol names and perhaps of the other
// generation. So the core never links Embree: the plugin does, it is opened in a scope of its own, and the core calls
// through this table alone (docs/decisions/0008-rays.md).

namespace penumbra::embree {

/// Raised whenever the table or a ray layout changes, so that a stale plugin is refused instead of called.
inline constexpr int kTableVersion = 2;

struct Device;    // RTCDevice
struct Scene;     // RTCScene
struct Geometry;  // RTCGeometry

/// Layout of RTCRay in Embree 3 and 4 (checked in the plugin). `tfar` becomes -infinity where something is hit.
struct alignas(16) Ray {
    float org_x, org_y, org_z, tnear;
    float dir_x, dir_y, dir_z, time;
    float tfar;
    std::uint32_t mask, id, flags;
};

/// Layout of RTCRay4, RTCRay8 and RTCRay16.
template <int Lanes>
struct alignas(4 * Lanes) RayPacket {
    using Floats = std::array<float, Lanes>;
    using Words = std::array<std::uint32_t, Lanes>;
    Floats org_x, org_y, org_z, tnear;
    Floats dir_x, dir_y, dir_z, time;
    Floats tfar;
    Words mask, id, flags;
};

/// What a ray met first; where nothing, geometry is kNothing. Layout of RTCHit16 and its kin with one level of
/// instances.
template <int Lanes>
struct alignas(4 * Lanes) HitPacket {
    using Floats = std::array<float, Lanes>;
    using Words = std::array<std::uint32_t, Lanes>;
    Floats normal_x, normal_y, normal_z, u, v;
    Words triangle, geometry, instance;
};
inline constexpr std::uint32_t kNothing = ~0U;

/// Layout of RTCRayHit16 and its kin.
template <int Lanes>
struct RayHitPacket {
    RayPacket<Lanes> ray;
    HitPacket<Lanes> hit;
};

enum class Status : int { Ok = 0, OutOfMemory = 1, UnsupportedCpu = 2, Cancelled = 3, Failed = 4 };

/// Where the caller writes a mesh: 3 floats per vertex, 3 indices per triangle. Null where Embree had no memory.
struct TriangleBuffers {
    Geometry* geometry;
    float* positions;
    std::uint32_t* indices;
};

/// Asked while a scene is built; false stops the build.
using KeepGoing = bool (*)(void* user);

struct Table {
    int table_version;     ///< first member in every version of the table
    int compiled_version;  ///< RTC_VERSION of the headers the plugin was built with, 10000 major + 100 minor + patch

    Device* (*new_device)(const char* config);  ///< null: take_status(nullptr) tells why
    void (*release_device)(Device*);
    int (*loaded_version)(Device*);  ///< of the library that really answers, coded like compiled_version
    bool (*native_packets)(Device*, int lanes);
    Status (*take_status)(Device*);  ///< first error of this thread since the last call, and forgets it

    Scene* (*new_scene)(Device*);  ///< robust intersection: no ray slips through an edge that two triangles share
    void (*release_scene)(Scene*);
    TriangleBuffers (*new_triangles)(Device*, std::size_t vertices, std::size_t triangles);
    void (*attach_triangles)(Scene*, Geometry*);  ///< takes the geometry over
    /// @param scene_from_child 3 x 4, column major: three axis columns, then the translation
    void (*attach_instance)(Device*, Scene*, Scene* child, const float* scene_from_child);
    void (*commit)(Scene*, KeepGoing, void* user);

    void (*occluded1)(Scene*, Ray*);
    void (*occluded4)(const int* valid, Scene*, RayPacket<4>*);
    void (*occluded8)(const int* valid, Scene*, RayPacket<8>*);
    void (*occluded16)(const int* valid, Scene*, RayPacket<16>*);
    void (*first_hit16)(const int* valid, Scene*, RayHitPacket<16>*, bool coherent);
    void (*occluded_stream)(Scene*, Ray*, unsigned count);  ///< null in Embree 4, which dropped streams
};

using TableFunction = const Table* (*)();
inline constexpr const char* kTableSymbol = "penumbra_embree_table";

}  // namespace penumbra::embree
