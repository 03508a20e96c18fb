// The one file that includes Embree's headers and the one object that links its library: built as the shared library
// `penumbra_embree.so` and opened by embree_library.cpp. Both Embree generations are served; what differs between them
// is only how an occlusion query takes its options.

#if PENUMBRA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "reference/embree_table.h"

namespace penumbra::embree {
namespace {

static_assert(sizeof(Ray) == sizeof(RTCRay) && offsetof(Ray, tfar) == offsetof(RTCRay, tfar));
static_assert(sizeof(RayPacket<4>) == sizeof(RTCRay4) && offsetof(RayPacket<4>, tfar) == offsetof(RTCRay4, tfar));
static_assert(sizeof(RayPacket<8>) == sizeof(RTCRay8) && offsetof(RayPacket<8>, tfar) == offsetof(RTCRay8, tfar));
static_assert(sizeof(RayPacket<16>) == sizeof(RTCRay16) && offsetof(RayPacket<16>, tfar) == offsetof(RTCRay16, tfar));
static_assert(sizeof(RayHitPacket<16>) == sizeof(RTCRayHit16) && sizeof(HitPacket<16>) == sizeof(RTCHit16) &&
              offsetof(HitPacket<16>, geometry) == offsetof(RTCHit16, geomID) &&
              offsetof(HitPacket<16>, instance) == offsetof(RTCHit16, instID));

RTCDevice real(Device* device) {
    return reinterpret_cast<RTCDevice>(device);
}
RTCScene real(Scene* scene) {
    return reinterpret_cast<RTCScene>(scene);
}
RTCGeometry real(Geometry* geometry) {
    return reinterpret_cast<RTCGeometry>(geometry);
}

// Our packets are coherent, yet shadow rays are not declared so: with that flag Embree 3.13.5 was seen to loop for ever
// in rtcOccluded16 on instances, and without it it is no slower here (ray_bench.cpp). Camera rays take half the time
// with it, so they have it where there are no instances.
#if PENUMBRA_EMBREE_MAJOR >= 4
struct Query {
    RTCOccludedArguments arguments;
    Query() {
        rtcInitOccludedArguments(&arguments);
        arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    }
};
void occluded1(Scene* scene, Ray* ray) {
    Query query;
    rtcOccluded1(real(scene), reinterpret_cast<RTCRay*>(ray), &query.arguments);
}
void occluded4(const int* valid, Scene* scene, RayPacket<4>* rays) {
    Query query;
    rtcOccluded4(valid, real(scene), reinterpret_cast<RTCRay4*>(rays), &query.arguments);
}
void occluded8(const int* valid, Scene* scene, RayPacket<8>* rays) {
    Query query;
    rtcOccluded8(valid, real(scene), reinterpret_cast<RTCRay8*>(rays), &query.arguments);
}
void occluded16(const int* valid, Scene* scene, RayPacket<16>* rays) {
    Query query;
    rtcOccluded16(valid, real(scene), reinterpret_cast<RTCRay16*>(rays), &query.arguments);
}
void first_hit16(const int* valid, Scene* scene, RayHitPacket<16>* rays, bool coherent) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect16(valid, real(scene), reinterpret_cast<RTCRayHit16*>(rays), &arguments);
}
constexpr auto occluded_stream = static_cast<void (*)(Scene*, Ray*, unsigned)>(nullptr);
#else
struct Query {
    RTCIntersectContext context;
    Query() {
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
};
void occluded1(Scene* scene, Ray* ray) {
    Query query;
    rtcOccluded1(real(scene), &query.context, reinterpret_cast<RTCRay*>(ray));
}
void occluded4(const int* valid, Scene* scene, RayPacket<4>* rays) {
    Query query;
    rtcOccluded4(valid, real(scene), &query.context, reinterpret_cast<RTCRay4*>(rays));
}
void occluded8(const int* valid, Scene* scene, RayPacket<8>* rays) {
    Query query;
    rtcOccluded8(valid, real(scene), &query.context, reinterpret_cast<RTCRay8*>(rays));
}
void occluded16(const int* valid, Scene* scene, RayPacket<16>* rays) {
    Query query;
    rtcOccluded16(valid, real(scene), &query.context, reinterpret_cast<RTCRay16*>(rays));
}
void first_hit16(const int* valid, Scene* scene, RayHitPacket<16>* rays, bool coherent) {
    Query query;
    query.context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect16(valid, real(scene), &query.context, reinterpret_cast<RTCRayHit16*>(rays));
}
void occluded_stream(Scene* scene, Ray* rays, unsigned count) {
    Query query;
    rtcOccluded1M(real(scene), &query.context, reinterpret_cast<RTCRay*>(rays), count, sizeof(Ray));
}
#endif

Device* new_device(const char* config) {
    return reinterpret_cast<Device*>(rtcNewDevice(config));
}

void release_device(Device* device) {
    rtcReleaseDevice(real(device));
}

int loaded_version(Device* device) {
    return static_cast<int>(rtcGetDeviceProperty(real(device), RTC_DEVICE_PROPERTY_VERSION));
}

bool native_packets(Device* device, int lanes) {
    const auto has = [device](RTCDeviceProperty property) { return rtcGetDeviceProperty(real(device), property) != 0; };
    switch (lanes) {
        case 16:
            return has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED);
        case 8:
            return has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED);
        default:
            return has(RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED);
    }
}

Status take_status(Device* device) {
    switch (rtcGetDeviceError(real(device))) {
        case RTC_ERROR_NONE:
            return Status::Ok;
        case RTC_ERROR_OUT_OF_MEMORY:
            return Status::OutOfMemory;
        case RTC_ERROR_UNSUPPORTED_CPU:
            return Status::UnsupportedCpu;
        case RTC_ERROR_CANCELLED:
            return Status::Cancelled;
        default:
            return Status::Failed;
    }
}

Scene* new_scene(Device* device) {
    RTCScene scene = rtcNewScene(real(device));
    if (scene != nullptr) {
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    }
    return reinterpret_cast<Scene*>(scene);
}

void release_scene(Scene* scene) {
    rtcReleaseScene(real(scene));
}

TriangleBuffers new_triangles(Device* device, std::size_t vertices, std::size_t triangles) {
    RTCGeometry geometry = rtcNewGeometry(real(device), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (geometry == nullptr) {
        return {nullptr, nullptr, nullptr};
    }
    void* positions =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices);
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), triangles);
    if (positions == nullptr || indices == nullptr) {
        rtcReleaseGeometry(geometry);
        return {nullptr, nullptr, nullptr};
    }
    return {reinterpret_cast<Geometry*>(geometry), static_cast<float*>(positions),
            static_cast<std::uint32_t*>(indices)};
}

void attach_triangles(Scene* scene, Geometry* geometry) {
    rtcCommitGeometry(real(geometry));
    rtcAttachGeometry(real(scene), real(geometry));
    rtcReleaseGeometry(real(geometry));
}

void attach_instance(Device* device, Scene* scene, Scene* child, const float* scene_from_child) {
    RTCGeometry geometry = rtcNewGeometry(real(device), RTC_GEOMETRY_TYPE_INSTANCE);
    if (geometry == nullptr) {
        return;
    }
    rtcSetGeometryInstancedScene(geometry, real(child));
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, scene_from_child);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(real(scene), geometry);
    rtcReleaseGeometry(geometry);
}

struct Monitor {
    KeepGoing keep_going;
    void* user;
};

bool monitor(void* pointer, double /*done*/) {
    const auto* asked = static_cast<const Monitor*>(pointer);
    return asked->keep_going(asked->user);
}

void commit(Scene* scene, KeepGoing keep_going, void* user) {
    Monitor asked{keep_going, user};
    rtcSetSceneProgressMonitorFunction(real(scene), monitor, &asked);
    rtcCommitScene(real(scene));
    rtcSetSceneProgressMonitorFunction(real(scene), nullptr, nullptr);
}

const Table table{
    kTableVersion, RTC_VERSION,   new_device,    release_device,   loaded_version,  native_packets, take_status,
    new_scene,     release_scene, new_triangles, attach_triangles, attach_instance, commit,         occluded1,
    occluded4,     occluded8,     occluded16,    first_hit16,      occluded_stream,
};

}  // namespace
}  // namespace penumbra::embree

extern "C" __attribute__((visibility("default"))) const penumbra::embree::Table* penumbra_embree_table() {
    return &penumbra::embree::table;
}
