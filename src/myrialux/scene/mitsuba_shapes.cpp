// Shapes, groups and instances of Mitsuba scenes.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "myrialux/scene/mesh.h"
#include "myrialux/scene/mitsuba_reader.h"

namespace myrialux::mitsuba {

namespace {

const std::vector<std::string> kHere = {"obj",    "ply",  "serialized", "rectangle",  "cube",
                                        "sphere", "disk", "cylinder",   "shapegroup", "instance"};
const std::vector<std::string> kElsewhere = {"merge",      "bsplinecurve",   "linearcurve", "sdfgrid",
                                             "ellipsoids", "ellipsoidsmesh", "hair",        "heightfield",
                                             "deformable", "volume_grid"};
const Range kPositive{0, 1e30, true, "greater than 0"};

/// Reads one shape with geometry; nothing after a mistake. Who calls says where it stands.
std::optional<ShapeId> read_geometry(Reader& in, const Object& object, bool in_group);
void read_group(Reader& in, const Object& object);
void read_instance(Reader& in, const Object& object);
MeshId add_mesh(Reader& in, Mesh mesh, MeshJob job);
MeshId read_mesh_file(Reader& in, Fields& fields, const Transform& to_world);
void take_converted_file(MeshJob& job, Diagnostics& found);
std::optional<Quadric> read_quadric(Fields& fields, const Transform& to_world);
void read_surroundings(Reader& in, const Object& object, Shape& shape, const Object*& emitter);

}  // namespace

void read_shape(Reader& in, const Object& object) {
  if (object.type == "shapegroup") return read_group(in, object);
  if (object.type == "instance") return read_instance(in, object);
  if (const std::optional<ShapeId> shape = read_geometry(in, object, false)) in.scene.placed.push_back(*shape);
}

namespace {

std::optional<ShapeId> read_geometry(Reader& in, const Object& object, bool in_group) {
  Fields fields(object, in.found);
  Shape shape;
  shape.name = object.id.empty() ? object.spelled_type : object.id;
  shape.at = object.at;
  const Object* emitter = nullptr;
  read_surroundings(in, object, shape, emitter);
  const Transform to_world = fields.transform("to_world");
  shape.flip_normals = fields.boolean("flip_normals", false);
  const std::string& type = object.type;
  if (type == "obj" || type == "ply" || type == "serialized") {
    if (object.id.empty() && fields.has("filename"))
      shape.name = std::filesystem::path(fields.text("filename", "")).filename().string();
    const MeshId mesh = read_mesh_file(in, fields, to_world);
    if (mesh == kNone<MeshId>) return {};
    in.scene.meshes[index(mesh)].name = shape.name;
    shape.geometry = mesh;
  } else if (type == "rectangle" || type == "cube") {
    MeshJob job;
    job.at = object.at, job.to_world = to_world, job.smooth = false;
    fields.ignore({"face_normals"});
    shape.geometry = add_mesh(in, type == "cube" ? cube_mesh() : rectangle_mesh(), job);
    in.scene.meshes.back().name = shape.name;
  } else if (type == "sphere" || type == "disk" || type == "cylinder") {
    const std::optional<Quadric> quadric = read_quadric(fields, to_world);
    if (!quadric) return {};
    shape.geometry = *quadric;
  } else {
    report_type(in, object, kHere, kElsewhere);
    return {};
  }
  fields.finish();
  in.scene.shapes.push_back(std::move(shape));
  const ShapeId id = static_cast<ShapeId>(in.scene.shapes.size() - 1);
  if (emitter && in_group)
    in.found.error(emitter->at, "an area emitter on an instanced shape; allowed: emitters on shapes that stand alone");
  else if (emitter)
    read_area_emitter(in, *emitter, id);
  return id;
}

/// Material, emitter and media of a shape.
void read_surroundings(Reader& in, const Object& object, Shape& shape, const Object*& emitter) {
  bool has_bsdf = false, has_medium = false;
  for (const Child& child : object.children) {
    if (!child.object) continue;
    const Object& part = *child.object;
    if (part.tag != "bsdf" && part.tag != "emitter" && part.tag != "medium" && part.tag != "subsurface") continue;
    child.used = true;
    if (part.tag == "medium") has_medium = true, read_medium(in, part);
    if (part.tag == "subsurface") report_type(in, part, {}, {"dipole", "singlescatter", part.type});
    if (part.tag == "bsdf") {
      if (has_bsdf) in.found.error(child.at, "a second bsdf on a shape; allowed: one");
      has_bsdf = true;
      shape.material = read_material(in, part);
    } else if (part.tag == "emitter") {
      if (emitter) in.found.error(child.at, "a second emitter on a shape; allowed: one");
      emitter = &part;
    }
  }
  if (shape.material != kNone<MaterialId>) return;
  shape.material = default_material(in, emitter != nullptr);
  if (has_medium && object.old_dialect) {  // up to 0.6 such a shape is only the border of its medium
    Material border;
    border.name = "border of a medium", border.at = object.at, border.kind = BsdfKind::null;
    in.scene.materials.push_back(std::move(border));
    shape.material = static_cast<MaterialId>(in.scene.materials.size() - 1);
  }
}

MeshId add_mesh(Reader& in, Mesh mesh, MeshJob job) {
  in.scene.meshes.push_back(std::move(mesh));
  job.mesh = static_cast<MeshId>(in.scene.meshes.size() - 1);
  const MeshId id = job.mesh;
  in.assets.add(std::move(job));
  return id;
}

MeshId read_mesh_file(Reader& in, Fields& fields, const Transform& to_world) {
  const std::string& type = fields.object().type;
  MeshJob job;
  job.format = type == "obj"   ? MeshJob::Format::obj
               : type == "ply" ? MeshJob::Format::ply
                               : MeshJob::Format::serialized;
  job.path = read_filename(in, fields);
  job.at = fields.at("filename");
  job.to_world = to_world;
  job.face_normals = fields.boolean("face_normals", false);
  job.flip_v = fields.boolean("flip_tex_coords", type == "obj");
  if (type == "serialized") job.shape_index = static_cast<int>(fields.integer("shape_index", 0, 0, 1 << 30));
  if (fields.has("max_smooth_angle")) {
    fields.found().warning(fields.at("max_smooth_angle"),
                           "maxSmoothAngle is not followed: normals are those of the file");
    fields.ignore({"max_smooth_angle"});
  }
  fields.ignore({"collapse", "srgb", "load_materials", "name"});
  if (job.path.empty()) return kNone<MeshId>;
  take_converted_file(job, fields.found());
  return add_mesh(in, {}, std::move(job));
}

/// Published scenes often come with their OBJ files converted to PLY; a missing OBJ is then no obstacle.
void take_converted_file(MeshJob& job, Diagnostics& found) {
  std::error_code code;
  if (std::filesystem::is_regular_file(job.path, code)) return;
  const std::string converted = std::filesystem::path(job.path).replace_extension(".ply").string();
  if (job.format != MeshJob::Format::obj || !std::filesystem::is_regular_file(converted, code)) {
    job.format = MeshJob::Format::ready;  // told here, so not again by the reader
    return found.error(job.at, "mesh file " + std::exchange(job.path, "") + " does not exist");
  }
  found.warning(job.at, "mesh file " + job.path + " does not exist: " + converted + " is read instead");
  job.path = converted;
  job.format = MeshJob::Format::ply;
}

/// Rotation and scale that carry +z to `axis` (not 0), lengths along z included.
Transform along(Vec3 axis) {
  const float norm = length(axis);
  const Frame frame(axis * (1 / norm));
  return Transform(
      {frame.s.x, frame.t.x, axis.x, 0, frame.s.y, frame.t.y, axis.y, 0, frame.s.z, frame.t.z, axis.z, 0, 0, 0, 0, 1});
}

std::optional<Quadric> read_quadric(Fields& fields, const Transform& to_world) {
  const std::string& type = fields.object().type;
  if (type == "disk") return Quadric{Quadric::Kind::disk, to_world};
  const float radius = static_cast<float>(fields.number("radius", 1, kPositive));
  if (type == "cylinder") {
    const Vec3 p0 = fields.vector("p0", {0, 0, 0}), p1 = fields.vector("p1", {0, 0, 1});
    if (!(length(p1 - p0) > 0)) {
      fields.error("p1", "cylinder: p0 and p1 are the same point; allowed: two different points");
      return {};
    }
    return Quadric{Quadric::Kind::cylinder,
                   to_world * Transform::translate(p0) * along(p1 - p0) * Transform::scale({radius, radius, 1})};
  }
  const Vec3 centre = fields.vector("center", {0, 0, 0});
  const Transform all = to_world * Transform::translate(centre) * Transform::scale({radius, radius, radius});
  // columns at right angles and of one length: else it is an ellipsoid
  const auto& m = all.rows();
  double dots[6];
  for (int k = 0, a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b, ++k) dots[k] = m[a] * m[b] + m[4 + a] * m[4 + b] + m[8 + a] * m[8 + b];
  const double size = dots[0];
  const bool is_sphere = std::abs(dots[3] - size) < 1e-3 * size && std::abs(dots[5] - size) < 1e-3 * size &&
                         std::abs(dots[1]) < 1e-3 * size && std::abs(dots[2]) < 1e-3 * size &&
                         std::abs(dots[4]) < 1e-3 * size;
  if (!is_sphere) {
    fields.found().unsupported(
        fields.at("to_world"),
        "sphere: its transform makes an ellipsoid, which cannot be rendered; allowed: rotations, "
        "translations, one scale for all axes");
    return {};
  }
  return Quadric{Quadric::Kind::sphere, all};
}

void read_group(Reader& in, const Object& object) {
  if (in.groups.contains(&object)) return;
  ShapeGroup group;
  for (const Child& child : object.children) {
    child.used = true;
    if (!child.object) continue;
    const Object& part = *child.object;
    if (part.tag == "shape" && part.type != "shapegroup" && part.type != "instance") {
      if (const std::optional<ShapeId> shape = read_geometry(in, part, true)) group.shapes.push_back(*shape);
    } else if (part.tag == "emitter") {
      in.found.error(child.at, "an area emitter on an instanced shape; allowed: emitters on shapes that stand alone");
    } else {
      in.found.error(child.at, fmt::format("<{} type=\"{}\"> in a shapegroup; allowed: shapes with geometry", part.tag,
                                           part.spelled_type));
    }
  }
  Fields(object, in.found).finish();
  in.groups.emplace(&object, static_cast<std::uint32_t>(in.scene.groups.size()));
  in.scene.groups.push_back(std::move(group));
}

void read_instance(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  Instance instance;
  instance.to_world = fields.transform("to_world");
  bool has_group = false;
  for (const Child& child : object.children) {
    if (!child.object) {
      has_group = true;  // its absence has been told
    } else if (child.object->tag == "emitter") {
      child.used = true;
      in.found.error(child.at, "an area emitter on an instanced shape; allowed: emitters on shapes that stand alone");
    } else if (child.object->type == "shapegroup") {
      child.used = true;
      read_group(in, *child.object);
      instance.group = in.groups.at(child.object);
      if (has_group) in.found.error(child.at, "a second shapegroup in an instance; allowed: one");
      has_group = true;
    }
  }
  if (!has_group) return in.found.error(object.at, "instance names no shapegroup; add <ref id=\"...\"/>");
  fields.finish();
  in.scene.instances.push_back(instance);
}

}  // namespace

}  // namespace myrialux::mitsuba
