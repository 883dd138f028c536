// What Embree's callbacks and the queries share: the built scene, one record a geometry, and the context of a query.
// Internal to trace/.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "myrialux/scene/scene.h"
#include "myrialux/scene/shape_point.h"
#include "myrialux/trace/embree.h"
#include "myrialux/trace/tracer.h"

namespace myrialux {

/// One Embree geometry: its user data.
struct GeometryRecord {
  const Scene* scene = nullptr;
  ShapeId shape = kNone<ShapeId>;
  bool is_masked = false;  ///< opacity below 1 somewhere
  bool is_null = false;    ///< never blocks
  Transform from_world;    ///< quadrics: to the unit shape's space (inside the group, for instanced shapes)
  const Shape& the_shape() const { return scene->shapes[index(shape)]; }
  const Material& material() const { return scene->materials[index(the_shape().material)]; }
};

/// Static acceleration structures: meshes, quadrics and instances apart. Geometry ids are common to all three: placed
/// shapes in order, then instances in order.
/// Apart, because Embree 3.13.5's coherent traversal may not return when one scene holds several kinds: it sorts lanes
/// by octant, and lanes that another kind has found blocked before match none. Only meshes are traced as coherent, and
/// lanes found blocked are taken out between the kinds.
struct Acceleration {
  explicit Acceleration(const Scene& scene);
  ~Acceleration();
  Acceleration(const Acceleration&) = delete;
  Acceleration& operator=(const Acceleration&) = delete;

  const Scene& scene;
  RTCDevice device = nullptr;
  RTCScene meshes = nullptr;                         ///< always there
  RTCScene quadrics = nullptr, instances = nullptr;  ///< null if there are none
  std::vector<RTCScene> group_scenes;
  std::vector<GeometryRecord> placed;                ///< [Scene::placed]
  std::vector<std::vector<GeometryRecord>> grouped;  ///< [group][shape in it]
  std::vector<Placement> placements;                 ///< [Scene::instances]
  std::atomic<std::int64_t> bytes{0};
  bool has_native_16 = false;
  Box3 bounds;

  /// The instance with that Embree id, or null for shapes in the world.
  const Placement* placement(unsigned instance) const {
    return instance == RTC_INVALID_GEOMETRY_ID ? nullptr : &placements[instance - placed.size()];
  }
  const GeometryRecord& record(unsigned instance, unsigned geometry) const {
    return instance == RTC_INVALID_GEOMETRY_ID ? placed[geometry]
                                               : grouped[scene.instances[instance - placed.size()].group][geometry];
  }
};

/// Context of a query; Embree hands `embree` to the callbacks. Rays are found by their id (0 .. N-1), as they were
/// passed in: rays inside instances are rounded differently by each packet width, these are not.
struct QueryContext {
  EmbreeContext embree;
  const Acceleration* acceleration;
  const float* from[3];  ///< x, y, z of the origins, one a lane
  const float* to[3];    ///< ends, or directions
  bool to_is_direction;
  Vec3 origin(unsigned lane) const { return {from[0][lane], from[1][lane], from[2][lane]}; }
  Vec3 direction(unsigned lane) const {
    const Vec3 t{to[0][lane], to[1][lane], to[2][lane]};
    return to_is_direction ? t : t - origin(lane);
  }
};

/// Is the material's opacity below 1 somewhere?
bool has_cutouts(const Scene& scene, const Material& material);

/// Does a hit on a masked surface count? Decided by a hash of the ray as passed in and of what was hit, so that all
/// packet widths agree; true with probability opacity(uv) over rays. `crossing` tells a quadric's two hits apart.
bool mask_keeps(const Scene& scene, const Material& material, Vec2 uv, Vec3 origin, Vec3 direction, unsigned instance,
                unsigned geometry, unsigned primitive, unsigned crossing);

/// Embree callbacks; geometryUserPtr is a GeometryRecord.
void mask_filter(const RTCFilterFunctionNArguments* a);  ///< rejects cut-outs on meshes
void pass_filter(const RTCFilterFunctionNArguments* a);  ///< rejects all: null surfaces do not block
void quadric_bounds(const RTCBoundsFunctionArguments* a);
void quadric_intersect(const RTCIntersectFunctionNArguments* a);
void quadric_occluded(const RTCOccludedFunctionNArguments* a);

}  // namespace myrialux
