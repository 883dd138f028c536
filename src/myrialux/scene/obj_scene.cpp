// Builds a scene from an OBJ file and its MTL files: Kd, map_Kd, Ks, Ns, Ke, d, Tr, map_d.
#include "myrialux/scene/obj_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>

#include "myrialux/scene/obj.h"
#include "myrialux/scene/text.h"

namespace myrialux {

namespace {

struct MtlMaterial {
  Material material;
  Rgb emission;
  Rgb specular;              ///< Ks
  TextPosition specular_at;  ///< of Ks
  float exponent = 0;        ///< Ns
};

class MtlReader {
 public:
  MtlReader(Scene& scene, AssetJobs& assets, Diagnostics& found) : scene_(scene), assets_(assets), found_(found) {}
  void read(const std::string& path, const std::string& text);
  std::map<std::string, MtlMaterial> materials;

 private:
  void read_line(std::string_view line, const TextPosition& at, const std::filesystem::path& folder);
  std::optional<Rgb> read_rgb(std::string_view text, const TextPosition& at, double upper);
  std::optional<float> read_number(std::string_view text, const TextPosition& at, double upper);
  TextureId read_map(std::string_view text, const TextPosition& at, const std::filesystem::path& folder, bool raw);
  Scene& scene_;
  AssetJobs& assets_;
  Diagnostics& found_;
  MtlMaterial* current_ = nullptr;
};

void finish(MtlMaterial& m, Diagnostics& found);
Camera framing_camera(const Box3& box, const FilmDescription& film);

}  // namespace

void read_obj_scene(const std::string& path, Scene& scene, AssetJobs& assets, std::string& text, Diagnostics& found) {
  text = read_file(path).value_or("");
  ObjFile file = read_obj_file(path, true, found);
  MtlReader mtl(scene, assets, found);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  for (const auto& [name, at] : file.material_files) {
    const std::string mtl_path = (folder / name).string();
    const std::optional<std::string> mtl_text = read_file(mtl_path);
    if (!mtl_text) {
      found.error(at, "material file \"" + name + "\" does not exist");
      continue;
    }
    text += *mtl_text;
    mtl.read(mtl_path, *mtl_text);
  }
  Box3 box;
  bool emits = false;
  for (ObjPart& part : file.parts) {
    if (part.mesh.indices.empty()) continue;
    const auto known = mtl.materials.find(part.material);
    if (known == mtl.materials.end() && !part.material.empty() && !found.has(Severity::error))
      found.warning(part.at, "material \"" + part.material + "\" is in no mtllib: rendered as grey");
    MtlMaterial m = known == mtl.materials.end() ? MtlMaterial{} : known->second;
    finish(m, found);
    m.material.name = part.material.empty() ? "default" : part.material;
    if (m.material.at.file.empty()) m.material.at = part.at;
    for (const Vec3& p : part.mesh.positions) box.add(p);
    part.mesh.name = m.material.name;
    Shape shape{m.material.name,
                part.at,
                static_cast<MeshId>(scene.meshes.size()),
                static_cast<MaterialId>(scene.materials.size()),
                kNone<EmitterId>,
                false};
    if (shape.at.file.empty()) shape.at = {path, 0, 0};
    MeshJob job;
    job.at = shape.at, job.mesh = std::get<MeshId>(shape.geometry), job.flip_v = true;
    if (!is_black(m.emission)) {
      emits = true;
      shape.emitter = static_cast<EmitterId>(scene.emitters.size());
      const ShapeId id = static_cast<ShapeId>(scene.shapes.size());
      scene.emitters.push_back({m.material.name, m.material.at, AreaEmitter{id, {m.emission}}});
    }
    scene.placed.push_back(static_cast<ShapeId>(scene.shapes.size()));
    scene.meshes.push_back(std::move(part.mesh));
    scene.materials.push_back(std::move(m.material));
    scene.shapes.push_back(std::move(shape));
    assets.add(std::move(job));
  }
  if (scene.placed.empty() && !found.has(Severity::error))
    found.error({path, 0, 0}, "holds no faces; allowed: at least one");
  if (!emits) scene.emitters.push_back({"sky", {path, 0, 0}, ConstantEmitter{gray(1)}});
  if (!box.is_empty()) scene.camera = framing_camera(box, scene.film);
}

namespace {

void MtlReader::read(const std::string& path, const std::string& text) {
  current_ = nullptr;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::uint32_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    read_line(trim(std::string_view(text).substr(at, end - at)), {path, ++line, 0}, folder);
    at = end + 1;
  }
}

std::optional<float> MtlReader::read_number(std::string_view text, const TextPosition& at, double upper) {
  const auto number = parse_number(text);
  if (number && *number >= 0 && *number <= upper) return static_cast<float>(*number);
  found_.error(at, fmt::format("\"{}\"; allowed: a number from 0 to {}", std::string(text.substr(0, 40)), show(upper)));
  return {};
}

std::optional<Rgb> MtlReader::read_rgb(std::string_view text, const TextPosition& at, double upper) {
  const auto n = parse_numbers(text);
  const bool has_three = n && (n->size() == 3 || n->size() == 1);
  if (has_three && std::all_of(n->begin(), n->end(), [&](double v) { return v >= 0 && v <= upper; }))
    return n->size() == 1 ? gray(static_cast<float>((*n)[0]))
                          : Rgb{static_cast<float>((*n)[0]), static_cast<float>((*n)[1]), static_cast<float>((*n)[2])};
  found_.error(at, fmt::format("\"{}\"; allowed: one or three numbers from 0 to {}", std::string(text.substr(0, 40)),
                               show(upper)));
  return {};
}

TextureId MtlReader::read_map(std::string_view text, const TextPosition& at, const std::filesystem::path& folder,
                              bool raw) {
  if (text.starts_with('-')) found_.warning(at, "options of a map are not followed");
  while (text.starts_with('-')) {  // an option and its numbers end before the last word
    const std::size_t space = text.rfind(' ');
    if (space == text.npos) break;
    text = trim(text.substr(space));
  }
  std::string name(text);
  std::replace(name.begin(), name.end(), '\\', '/');
  Texture texture;
  texture.name = name;
  texture.image = assets_.add_image((folder / name).string(), raw, 0, at);
  scene_.textures.push_back(std::move(texture));
  return static_cast<TextureId>(scene_.textures.size() - 1);
}

void MtlReader::read_line(std::string_view line, const TextPosition& at, const std::filesystem::path& folder) {
  if (line.empty() || line.front() == '#') return;
  const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
  const std::string_view key = line.substr(0, end), rest = trim(line.substr(end));
  if (key == "newmtl") {
    current_ = &materials[std::string(rest)];
    *current_ = {};
    current_->material.at = at;
    return;
  }
  if (!current_) return found_.error(at, fmt::format("\"{}\" before the first newmtl", std::string(key.substr(0, 40))));
  Material& m = current_->material;
  if (key == "Kd") {
    if (const auto c = read_rgb(rest, at, 1)) m.reflectance.value = *c;
  } else if (key == "Ks") {
    if (const auto c = read_rgb(rest, at, 1e3)) current_->specular = *c, current_->specular_at = at;
  } else if (key == "Ke") {
    if (const auto c = read_rgb(rest, at, 1e30)) current_->emission = *c;
  } else if (key == "Ns") {
    if (const auto x = read_number(rest, at, 1e6)) current_->exponent = *x;
  } else if (key == "d") {
    if (const auto x = read_number(rest, at, 1)) m.opacity.value = gray(*x);
  } else if (key == "Tr") {
    if (const auto x = read_number(rest, at, 1)) m.opacity.value = gray(1 - *x);
  } else if (key == "map_Kd") {
    m.reflectance.texture = read_map(rest, at, folder, false);
  } else if (key == "map_d") {
    m.opacity.texture = read_map(rest, at, folder, true);
  }  // Ka, Ni, illum, Tf, bump maps: no part of this model
}

/// Kd, Ks, Ns shade as Lambert and Blinn-Phong; without Ks or Ns as Lambert alone.
void finish(MtlMaterial& m, Diagnostics& found) {
  Material& material = m.material;
  material.two_sided = true;
  const bool has_map = material.reflectance.texture != kNone<TextureId>;
  if (has_map && is_black(material.reflectance.value))
    material.reflectance.value = gray(1);  // exporters write Kd 0 beside a map
  if (max_component(m.specular) <= 0 || m.exponent <= 0) return;
  material.kind = BsdfKind::blinn_phong;
  material.specular.value = m.specular;
  material.alpha = material.alpha_v = {gray(std::sqrt(2 / (m.exponent + 2)))};

  const float most = max_component(material.reflectance.value + m.specular);
  if (most <= 1 + 1e-5f) return;  // sums of rounded decimals pass 1 by a little
  if (has_map)
    return found.warning(m.specular_at, fmt::format("Kd and Ks together reflect up to {} where map_Kd is white; points "
                                                    "that reflect more than 1 are scaled down to 1",
                                                    show(most)));
  found.warning(m.specular_at, fmt::format("Kd and Ks together reflect {}: both are divided by it", show(most)));
  material.reflectance.value = material.reflectance.value / gray(most);
  material.specular.value = material.specular.value / gray(most);
}

/// From the front, right and above (+y is up), so far away that the sphere around the box fills the smaller angle.
Camera framing_camera(const Box3& box, const FilmDescription& film) {
  Camera camera;
  const float radius = std::max(0.5f * box.diagonal(), 1e-6f);
  camera.fov_x_deg = 45;
  const float half_x = std::tan(0.5f * camera.fov_x_deg * kPi / 180);
  const float half =
      std::atan(half_x * std::min(1.0f, static_cast<float>(film.height) / static_cast<float>(film.width)));
  const float distance = radius / std::sin(half);
  const Vec3 centre = box.centre();
  camera.to_world = Transform::look_at(centre + normalize({1, 0.7f, 1.4f}) * distance, centre, {0, 1, 0});
  camera.near_clip = 1e-3f * distance;
  camera.far_clip = 10 * distance;
  return camera;
}

}  // namespace

}  // namespace myrialux
