// Second half of the view: position and normals from the seen triangle, in float64, so that neither large triangles
// nor a scene far from the origin cost precision; only results relative to the eye become float32.
#include "lib/receiver.glsl"
#include "shared/instance_block.h"

layout(std430, binding = 0) readonly buffer Instances { InstanceExact instances[]; };
layout(std430, binding = 1) readonly buffer Positions { float positions[]; };
layout(std430, binding = 2) readonly buffer Indices { uint indices[]; };
layout(std430, binding = 3) readonly buffer Normals { float corner_normals[]; };
layout(std430, binding = 4) readonly buffer Materials { uint materials[]; };
layout(std430, binding = 5) readonly buffer Albedos { vec4 albedos[]; };
layout(binding = 0) uniform usampler2D ids_texture;

// Columns of the camera in world axes; ray = forward + x right + y up (perspective), or parallel rays.
uniform dvec3 right;
uniform dvec3 up;
uniform dvec3 forward;
uniform dvec4 window;  // ray x = window.x + window.z * pixel x, y likewise with window.y, window.w
uniform int orthographic;

layout(location = 0) out vec4 position_cr;
layout(location = 1) out vec4 normal_ws;
layout(location = 2) out vec4 shading_normal_ws;
layout(location = 3) out vec4 albedo;
layout(location = 4) out uvec4 receiver;

dvec3 to_eye(InstanceExact instance, vec3 p_local) {
    dvec4 p = dvec4(dvec3(p_local), 1.0lf);
    return dvec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
}

vec3 local_position(InstanceExact instance, uint index) {
    uint at = 3u * (instance.first_vertex + index);
    return vec3(positions[at], positions[at + 1u], positions[at + 2u]);
}

vec3 local_normal(InstanceExact instance, uint corner) {
    uint at = instance.first_normal + 3u * corner;
    return vec3(corner_normals[at], corner_normals[at + 1u], corner_normals[at + 2u]);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ids = texelFetch(ids_texture, pixel, 0).rg;
    position_cr = vec4(0.0);
    normal_ws = vec4(0.0);
    shading_normal_ws = vec4(0.0);
    albedo = vec4(0.0);
    receiver = uvec4(0u);
    if (ids.x == 0u) {
        return;
    }
    InstanceExact instance = instances[ids.x - 1u];
    uint at = instance.first_index + 3u * ids.y;
    dvec3 a = to_eye(instance, local_position(instance, indices[at]));
    dvec3 b = to_eye(instance, local_position(instance, indices[at + 1u]));
    dvec3 c = to_eye(instance, local_position(instance, indices[at + 2u]));

    double x = window.x + window.z * double(pixel.x);
    double y = window.y + window.w * double(pixel.y);
    dvec3 origin = orthographic != 0 ? x * right + y * up : dvec3(0.0lf);
    dvec3 ray = orthographic != 0 ? forward : forward + x * right + y * up;

    dvec3 n = cross(b - a, c - a);
    double along = dot(n, ray);
    double t = along != 0.0lf ? dot(n, a - origin) / along : 0.0lf;
    dvec3 p = origin + t * ray;
    // A triangle seen edge-on has no well placed intersection: stay within its box.
    p = clamp(p, min(min(a, b), c), max(max(a, b), c));

    double area = length(n);
    if (!(area > 0.0lf)) {
        return;
    }
    n = along > 0.0lf ? -n / area : n / area;  // turned towards the camera
    dvec3 shading = n;
    if (instance.first_normal != 0xffffffffu) {
        // Barycentric coordinates of p from the three sub-areas along n.
        dvec3 m = cross(b - a, c - a);
        double whole = dot(m, m);
        double v = dot(m, cross(p - a, c - a)) / whole;
        double w = dot(m, cross(b - a, p - a)) / whole;
        dvec3 local = dvec3(local_normal(instance, 3u * ids.y)) * (1.0lf - v - w) +
                      dvec3(local_normal(instance, 3u * ids.y + 1u)) * v +
                      dvec3(local_normal(instance, 3u * ids.y + 2u)) * w;
        // Normals go with the cofactors of the linear part, also mirrored and sheared.
        dvec3 r0 = instance.rows[0].xyz, r1 = instance.rows[1].xyz, r2 = instance.rows[2].xyz;
        dvec3 turned = dvec3(dot(cross(r1, r2), local), dot(cross(r2, r0), local), dot(cross(r0, r1), local));
        double size = length(turned);
        if (size > 0.0lf) {
            shading = dot(turned, n) < 0.0lf ? -turned / size : turned / size;
        }
    }
    uint slot = instance.first_material == 0xffffffffu ? 0u : materials[instance.first_material + ids.y];
    position_cr = vec4(vec3(p), 1.0);
    normal_ws = vec4(vec3(n), 0.0);
    receiver = uvec4(floatBitsToUint(vec3(p)), pack_normal(vec3(n)));
    shading_normal_ws = vec4(vec3(shading), 0.0);
    albedo = vec4(albedos[instance.first_albedo + min(slot, instance.albedo_count - 1u)].rgb, 1.0);
}
