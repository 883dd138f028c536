// Builds the acceleration structure: meshes as triangles, quadrics as user geometry, groups as instanced scenes.
#include "myrialux/trace/acceleration.h"

#include <algorithm>
#include <string>

#include "myrialux/base/assert.h"
#include "myrialux/base/error.h"
#include "myrialux/base/handover.h"

namespace myrialux {

namespace {

#ifdef MYRIALUX_SANITIZE_THREAD
constexpr const char* kDeviceConfig = "threads=1";  // how Embree's threads hand over their work cannot be seen
#else
constexpr const char* kDeviceConfig = nullptr;
#endif

/// Throws what the device has to say since the last call; `doing` completes the message.
void check(RTCDevice device, const Scene& scene, const char* doing);
/// Adds the shape to an Embree scene under the given id. Empty meshes are left out.
void attach(RTCDevice device, RTCScene to, unsigned id, const Scene& scene, ShapeId shape, GeometryRecord& record);
void attach_instance(RTCDevice device, RTCScene to, unsigned id, const Instance& instance, RTCScene group);
RTCGeometry mesh_geometry(RTCDevice device, const Mesh& mesh);
void commit(RTCScene scene);

bool count_bytes(void* counter, ssize_t bytes, bool) {
  static_cast<std::atomic<std::int64_t>*>(counter)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

}  // namespace

Acceleration::Acceleration(const Scene& s) : scene(s) {
  device = rtcNewDevice(kDeviceConfig);
  check(device, scene, "starting Embree");
  rtcSetDeviceMemoryMonitorFunction(device, count_bytes, &bytes);
  has_native_16 = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;

  // Records must not move once Embree points to them.
  placed.resize(scene.placed.size());
  grouped.resize(scene.groups.size());
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const std::vector<ShapeId>& shapes = scene.groups[g].shapes;
    grouped[g].resize(shapes.size());
    group_scenes.push_back(rtcNewScene(device));
    for (std::size_t k = 0; k < shapes.size(); ++k)
      attach(device, group_scenes[g], static_cast<unsigned>(k), scene, shapes[k], grouped[g][k]);
    commit(group_scenes[g]);
  }

  meshes = rtcNewScene(device);
  for (std::size_t k = 0; k < placed.size(); ++k) {
    const bool is_quadric = std::holds_alternative<Quadric>(scene.shapes[index(scene.placed[k])].geometry);
    if (is_quadric && !quadrics) quadrics = rtcNewScene(device);
    attach(device, is_quadric ? quadrics : meshes, static_cast<unsigned>(k), scene, scene.placed[k], placed[k]);
  }
  if (!scene.instances.empty()) instances = rtcNewScene(device);
  for (const Instance& instance : scene.instances) {
    placements.emplace_back(instance.to_world);
    attach_instance(device, instances, static_cast<unsigned>(placed.size() + placements.size() - 1), instance,
                    group_scenes[instance.group]);
  }
  for (RTCScene kind : {meshes, quadrics, instances})
    if (kind) {
      commit(kind);
      RTCBounds box;
      rtcGetSceneBounds(kind, &box);
      bounds.add(Box3{{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}});
    }
  check(device, scene, "building the acceleration structure");
}

Acceleration::~Acceleration() {
  for (RTCScene group : group_scenes) rtcReleaseScene(group);
  for (RTCScene kind : {meshes, quadrics, instances})
    if (kind) rtcReleaseScene(kind);
  if (device) rtcReleaseDevice(device);
}

namespace {

void check(RTCDevice device, const Scene& scene, const char* doing) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  const std::string place = (scene.path.empty() ? std::string("scene") : scene.path) + ": ";
  if (code == RTC_ERROR_OUT_OF_MEMORY)
    throw Error(ErrorKind::limit, place + "not enough memory while " + doing + " for " +
                                      std::to_string(scene.n_triangles()) +
                                      " triangles; free some memory or simplify the meshes");
  if (code == RTC_ERROR_UNSUPPORTED_CPU)
    throw Error(ErrorKind::limit, place + "this processor lacks what Embree needs (SSE2 at least)");
  throw Error(ErrorKind::limit,
              place + "Embree refused " + doing + " (error " + std::to_string(static_cast<int>(code)) + ")");
}

void attach(RTCDevice device, RTCScene to, unsigned id, const Scene& scene, ShapeId shape, GeometryRecord& record) {
  const Shape& s = scene.shapes[index(shape)];
  record.scene = &scene;
  record.shape = shape;
  MYRIALUX_ASSERT(index(s.material) < scene.materials.size());
  record.is_masked = has_cutouts(scene, record.material());
  record.is_null = record.material().kind == BsdfKind::null;
  RTCGeometry geometry = nullptr;
  if (const MeshId* mesh_id = std::get_if<MeshId>(&s.geometry)) {
    const Mesh& mesh = scene.meshes[index(*mesh_id)];
    if (mesh.indices.empty()) return;
    geometry = mesh_geometry(device, mesh);
    if (record.is_masked) rtcSetGeometryIntersectFilterFunction(geometry, mask_filter);
    if (record.is_masked) rtcSetGeometryOccludedFilterFunction(geometry, mask_filter);
    if (record.is_null) rtcSetGeometryOccludedFilterFunction(geometry, pass_filter);
    rtcSetGeometryUserData(geometry, &record);
  } else {
    record.from_world = std::get<Quadric>(s.geometry).to_world.inverse();
    geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryUserData(geometry, &record);
    rtcSetGeometryBoundsFunction(geometry, quadric_bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, quadric_intersect);
    rtcSetGeometryOccludedFunction(geometry, quadric_occluded);
  }
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(to, geometry, id);
  rtcReleaseGeometry(geometry);
}

void attach_instance(RTCDevice device, RTCScene to, unsigned id, const Instance& instance, RTCScene group) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, group);
  float rows[12];
  for (int i = 0; i < 12; ++i) rows[i] = static_cast<float>(instance.to_world.rows()[i]);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(to, geometry, id);
  rtcReleaseGeometry(geometry);
}

RTCGeometry mesh_geometry(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::size_t n = mesh.positions.size();
  // Embree reads 16 bytes from each 12-byte vertex: the last one needs room behind it, or the vertices are copied.
  if (mesh.positions.capacity() > n) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                               sizeof(Vec3), n);
  } else {
    void* copy = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), n);
    if (copy) std::copy_n(mesh.positions.data(), n, static_cast<Vec3*>(copy));
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                             3 * sizeof(std::uint32_t), mesh.n_triangles());
  return geometry;
}

void commit(RTCScene scene) {
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_NONE);  // not robust: 15 % faster, errors are bounded by the offsets
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(scene);
}

}  // namespace

}  // namespace myrialux
