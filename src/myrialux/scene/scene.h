// Plain description of a scene: shapes, materials, textures, emitters, camera, film. Independent of file formats.
// Lengths are in scene units (metres by convention), radiance in W m^-2 sr^-1 per channel, colours linear Rec. 709.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/base/ids.h"
#include "myrialux/math/filter.h"
#include "myrialux/math/transform.h"
#include "myrialux/math/vec.h"
#include "myrialux/scene/texture.h"

namespace myrialux {

/// A colour that may vary over the surface: `value`, or `value` times the texture if there is one.
struct ColorSlot {
  Rgb value;
  TextureId texture = kNone<TextureId>;
};

/// Triangles in the space of their shape's owner (world, or the group's space for instanced shapes).
struct Mesh {
  std::string name;
  std::vector<Vec3> positions;         ///< [n_vertices]
  std::vector<Vec3> normals;           ///< [n_vertices], unit, or empty: shade with the geometric normal
  std::vector<Vec2> uvs;               ///< [n_vertices], or empty: barycentric coordinates serve
  std::vector<std::uint32_t> indices;  ///< [3 * n_triangles]
  std::size_t n_triangles() const { return indices.size() / 3; }
};

/// Exact curved shapes. Unit sphere at the origin; unit disc in z = 0 facing +z; unit cylinder from z = 0 to 1.
struct Quadric {
  enum class Kind : std::uint8_t { sphere, disk, cylinder };
  Kind kind = Kind::sphere;
  Transform to_world;  ///< for spheres: rotation, translation, uniform scale
};

struct Shape {
  std::string name;  ///< id or file name, for messages
  TextPosition at;
  std::variant<MeshId, Quadric> geometry;
  MaterialId material = kNone<MaterialId>;
  EmitterId emitter = kNone<EmitterId>;  ///< the area emitter on it, if any
  bool flip_normals = false;             ///< the geometric normal is turned around
};

/// Shapes that instances place; they carry no emitters.
struct ShapeGroup {
  std::vector<ShapeId> shapes;
};

struct Instance {
  std::uint32_t group = 0;  ///< into Scene::groups
  Transform to_world;
};

enum class BsdfKind : std::uint8_t {
  diffuse,
  conductor,
  rough_conductor,
  plastic,
  rough_plastic,
  blinn_phong,
  dielectric,
  thin_dielectric,
  rough_dielectric,
  null
};
enum class Microfacets : std::uint8_t { beckmann, ggx };

/// One BSDF and the adapters around it (two-sided, mask, bump), flattened. Unused fields keep their defaults.
struct Material {
  std::string name;
  TextPosition at;
  BsdfKind kind = BsdfKind::diffuse;
  Microfacets distribution = Microfacets::beckmann;
  bool nonlinear = false;                    ///< plastic: colour shifts from internal scattering
  bool two_sided = false;                    ///< the back behaves as `back` says (by default like the front)
  MaterialId back = kNone<MaterialId>;       ///< other material for the back of a two-sided surface
  ColorSlot reflectance{gray(0.5f)};         ///< diffuse part: diffuse, plastic, Blinn-Phong
  ColorSlot specular{gray(1)};               ///< factor on reflection
  ColorSlot transmittance{gray(1)};          ///< factor on refraction
  ColorSlot alpha{gray(0.1f)};               ///< roughness along the tangent (x) = .r, all channels equal
  ColorSlot alpha_v{gray(0.1f)};             ///< roughness along the bitangent (y)
  ColorSlot opacity{gray(1)};                ///< mask; mean of the channels
  TextureId bump = kNone<TextureId>;         ///< height or normal map; shaded unbumped in this version
  float eta = 1.5046f;                       ///< interior over exterior index of refraction
  Rgb eta_metal{0, 0, 0}, k_metal{1, 1, 1};  ///< complex index of a conductor; 0 + 1i reflects everything
};

struct AreaEmitter {
  ShapeId shape = kNone<ShapeId>;
  ColorSlot radiance;
};
struct ConstantEmitter {
  Rgb radiance;
};
struct EnvmapEmitter {
  TextureId image = kNone<TextureId>;
  float scale = 1;
  Transform to_world;
};
struct PointEmitter {
  Vec3 position;
  Rgb intensity;
};  ///< intensity: W/sr
struct SpotEmitter {
  Transform to_world;
  Rgb intensity;
  float cutoff_deg = 20, beam_deg = 15;
  TextureId texture = kNone<TextureId>;
};
struct DirectionalEmitter {
  Vec3 direction;
  Rgb irradiance;
};  ///< direction the light travels

struct Emitter {
  std::string name;
  TextPosition at;
  std::variant<AreaEmitter, ConstantEmitter, EnvmapEmitter, PointEmitter, SpotEmitter, DirectionalEmitter> kind;
};

/// Where a moving camera stands at one time.
struct CameraKey {
  double time = 0;
  Transform to_world;
};

/// Camera with a thin lens or a pinhole: looks along +z of `to_world`, +y up, +x to the left of the picture.
struct Camera {
  Transform to_world;
  float fov_x_deg = 45;                    ///< full horizontal angle (loaders convert fov_axis with the film's aspect)
  float principal_x = 0, principal_y = 0;  ///< offset of the principal point, fractions of width and height
  float near_clip = 1e-2f, far_clip = 1e4f;
  float aperture_radius = 0;      ///< of the lens, scene units; 0: pinhole
  float focus_distance = 0;       ///< along +z from the lens to the plane that is sharp; 0: unknown, pinholes only
  std::vector<CameraKey> motion;  ///< two keyframes at least, times rise, all rigid; or none: it stands at `to_world`
  double shutter_open = 0, shutter_close = 0;  ///< times, as those of the keyframes

  bool moves() const { return !motion.empty() && shutter_close > shutter_open; }
  /// Placement at a time: a keyframe's own, rigid between two; before the first and after the last it stands still.
  Transform at(double time) const;
};

struct FilmDescription {
  int width = 768, height = 576;
  Filter filter;
  int spp = 4;  ///< the file's sample count
};

struct Scene {
  std::string path;    ///< file it came from
  std::string sha256;  ///< of the scene file's text and of the list of files it names (name, size)
  std::vector<Mesh> meshes;
  std::vector<Shape> shapes;
  std::vector<ShapeId> placed;  ///< shapes that stand in the world by themselves (not in a group)
  std::vector<ShapeGroup> groups;
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Emitter> emitters;
  Camera camera;
  FilmDescription film;
  int max_depth = -1;  ///< of the file's integrator: path edges from the camera, -1 = no limit
  int rr_depth = 5;
  bool hide_emitters = false;
  std::uint64_t dropped_triangles = 0;  ///< of zero area or with repeated corners
  std::vector<Diagnostic> diagnostics;  ///< warnings and what cannot be rendered yet

  Box3 bounds() const;                ///< of everything placed, instances included
  std::uint64_t n_triangles() const;  ///< as placed: instanced triangles count once an instance
};

}  // namespace myrialux
