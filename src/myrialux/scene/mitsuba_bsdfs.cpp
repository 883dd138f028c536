// Materials of Mitsuba scenes: parameters with the meaning and the defaults of Mitsuba 3's plugins, adapters flattened.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "myrialux/scene/ior.h"
#include "myrialux/scene/mitsuba_reader.h"
#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

namespace {

const std::vector<std::string> kHere = {
    "diffuse",         "conductor", "roughconductor", "plastic", "roughplastic", "dielectric", "thindielectric",
    "roughdielectric", "twosided",  "mask",           "bumpmap", "normalmap",    "null"};
const std::vector<std::string> kElsewhere = {
    "principled",   "principledthin",     "blendbsdf", "coating",  "roughcoating", "phong",     "ward",
    "measured",     "measured_polarized", "hair",      "pplastic", "retarder",     "polarizer", "circular",
    "roughdiffuse", "difftrans",          "hk",        "irawan",   "mixturebsdf",  "roughbsdf"};

bool fill(Reader& in, const Object& object, Material& material);
void read_twosided(Reader& in, const Object& object, Material& material);
void read_adapter(Reader& in, const Object& object, Material& material);
void read_conductor(Reader& in, Fields& fields, Material& material);
void read_dielectric(Fields& fields, Material& material, float default_interior);
void read_plastic(Reader& in, Fields& fields, Material& material);
void read_roughness(Reader& in, Fields& fields, Material& material);
void read_reflections(Reader& in, Fields& fields, Material& material, bool transmits);
std::vector<const Object*> inner_bsdfs(Reader& in, const Object& object);
bool transmits(const Material& material);

}  // namespace

MaterialId read_material(Reader& in, const Object& object) {
  const auto known = in.materials.find(&object);
  if (known != in.materials.end()) return known->second;
  Material material;
  material.name = object.id.empty() ? object.spelled_type : object.id;
  material.at = object.at;
  fill(in, object, material);
  in.scene.materials.push_back(std::move(material));
  const MaterialId id = static_cast<MaterialId>(in.scene.materials.size() - 1);
  in.materials.emplace(&object, id);
  return id;
}

MaterialId default_material(Reader& in, bool is_emitter) {
  MaterialId& id = is_emitter ? in.black_material : in.default_material;
  if (id == kNone<MaterialId>) {
    Material material;
    material.name = is_emitter ? "default (emitter)" : "default";
    material.at = in.tree.scene().at;
    material.reflectance = {gray(is_emitter ? 0.0f : 0.5f)};
    in.scene.materials.push_back(std::move(material));
    id = static_cast<MaterialId>(in.scene.materials.size() - 1);
  }
  return id;
}

namespace {

/// Reads the object into `material`; adapters go on with what they hold. False after a mistake.
bool fill(Reader& in, const Object& object, Material& material) {
  Fields fields(object, in.found);
  const std::string& type = object.type;
  bool is_plugin = true;
  if (type == "twosided") {
    read_twosided(in, object, material);
  } else if (type == "mask" || type == "bumpmap" || type == "normalmap") {
    read_adapter(in, object, material);
  } else if (type == "diffuse") {
    material.kind = BsdfKind::diffuse;
    material.reflectance = read_slot(in, fields, "reflectance", gray(0.5f), ColorUse::reflectance);
    fields.finish();
  } else if (type == "conductor" || type == "roughconductor") {
    material.kind = type == "conductor" ? BsdfKind::conductor : BsdfKind::rough_conductor;
    read_conductor(in, fields, material);
    fields.finish();
  } else if (type == "plastic" || type == "roughplastic") {
    material.kind = type == "plastic" ? BsdfKind::plastic : BsdfKind::rough_plastic;
    read_plastic(in, fields, material);
    fields.finish();
  } else if (type == "dielectric" || type == "thindielectric" || type == "roughdielectric") {
    material.kind = type == "dielectric"       ? BsdfKind::dielectric
                    : type == "thindielectric" ? BsdfKind::thin_dielectric
                                               : BsdfKind::rough_dielectric;
    read_dielectric(fields, material, *dielectric_ior("bk7"));
    if (type == "roughdielectric") read_roughness(in, fields, material);
    read_reflections(in, fields, material, true);
    fields.finish();
  } else if (type == "null") {
    material.kind = BsdfKind::null;
    fields.finish();
  } else {
    report_type(in, object, kHere, kElsewhere);
    is_plugin = false;
  }
  return is_plugin;
}

/// The BSDFs inside an adapter, in order; other children stay for the adapter itself.
std::vector<const Object*> inner_bsdfs(Reader& in, const Object& object) {
  std::vector<const Object*> inner;
  for (const Child& child : object.children)
    if (child.object && child.object->tag == "bsdf") child.used = true, inner.push_back(child.object);
  const std::size_t n_allowed = object.type == "twosided" ? 2 : 1;
  if (inner.empty() || inner.size() > n_allowed) {
    const bool is_told =
        std::any_of(object.children.begin(), object.children.end(), [](const Child& c) { return !c.object; });
    if (!is_told)
      in.found.error(object.at, fmt::format("bsdf \"{}\" holds {} BSDFs; allowed: {}", object.spelled_type,
                                            inner.size(), n_allowed == 2 ? "1 or 2" : "1"));
    if (inner.size() > n_allowed) inner.resize(n_allowed);
  }
  return inner;
}

bool transmits(const Material& m) {
  return m.kind == BsdfKind::dielectric || m.kind == BsdfKind::thin_dielectric ||
         m.kind == BsdfKind::rough_dielectric || m.kind == BsdfKind::null;
}

void read_twosided(Reader& in, const Object& object, Material& material) {
  const std::vector<const Object*> inner = inner_bsdfs(in, object);
  Fields(object, in.found).finish();
  if (inner.empty()) return;
  const bool is_read = fill(in, *inner[0], material);
  material.two_sided = true;
  if (inner.size() == 2) material.back = read_material(in, *inner[1]);
  const bool back_transmits = inner.size() == 2 && transmits(in.scene.materials[index(material.back)]);
  if (is_read && (transmits(material) || back_transmits))
    in.found.error(object.at,
                   "bsdf \"twosided\" holds a BSDF that lets light through; allowed: BSDFs that only reflect");
}

/// mask: opacity over the inner BSDF. bumpmap, normalmap: the map is kept, but shading is that of the plain surface.
void read_adapter(Reader& in, const Object& object, Material& material) {
  Fields fields(object, in.found);
  for (const Object* inner : inner_bsdfs(in, object)) fill(in, *inner, material);
  if (object.type == "mask") {
    material.opacity = read_scalar_slot(in, fields, "opacity", 0.5f, {0, 1, false, "0 to 1"});
    return fields.finish();
  }
  for (const Child& child : object.children)
    if (child.object && child.object->tag == "texture") {
      child.used = true;
      const Object* map = child.object;
      if (map->type == "scale" && !map->children.empty() && map->children[0].object)
        accept_all(*map), map = map->children[0].object;
      if (map->tag == "texture") material.bump = read_texture(in, *map);
    }
  fields.ignore({"scale"});
  fields.finish();
  in.found.warning(object.at, fmt::format("bsdf \"{}\" is shaded without its bumps", object.spelled_type));
}

float read_ior(Fields& fields, const std::string& name, float missing) {
  const Property* p = fields.property(name);
  if (!p) return missing;
  const std::string* material = std::get_if<std::string>(&p->value);
  if (!material)
    return static_cast<float>(
        fields.number(name, missing, {0, 100, true, "greater than 0, at most 100, or the name of a material"}));
  if (const std::optional<float> ior = dielectric_ior(*material)) return *ior;
  fields.error(name, fmt::format("\"{}\" is \"{}\"{}; allowed: {}", p->spelled, *material,
                                 suggestion(*material, dielectric_names()), fmt::join(dielectric_names(), ", ")));
  return missing;
}

void read_dielectric(Fields& fields, Material& material, float default_interior) {
  const float interior = read_ior(fields, "int_ior", default_interior);
  const float exterior = read_ior(fields, "ext_ior", *dielectric_ior("air"));
  material.eta = static_cast<float>(static_cast<double>(interior) / exterior);
}

void read_reflections(Reader& in, Fields& fields, Material& material, bool transmits) {
  material.specular = read_slot(in, fields, "specular_reflectance", gray(1), ColorUse::factor);
  if (transmits) material.transmittance = read_slot(in, fields, "specular_transmittance", gray(1), ColorUse::factor);
}

void read_roughness(Reader& in, Fields& fields, Material& material) {
  const std::string distribution = fields.choice("distribution", "beckmann", {"beckmann", "ggx", "phong", "as"});
  material.distribution = distribution == "ggx" ? Microfacets::ggx : Microfacets::beckmann;
  if (distribution == "phong" || distribution == "as")
    fields.found().warning(fields.at("distribution"),
                           fmt::format("distribution \"{}\" is rendered as beckmann", distribution));
  fields.ignore({"sample_visible"});
  const Range range{0, 10, false, "0 to 10"};
  if (fields.has("alpha") && (fields.has("alpha_u") || fields.has("alpha_v")))
    fields.error("alpha", "both alpha and alpha_u or alpha_v are given; allowed: alpha alone, or the other two");
  material.alpha = read_scalar_slot(in, fields, "alpha", 0.1f, range);
  if (fields.has("alpha_u") || fields.has("alpha_v")) {
    const ColorSlot u = read_scalar_slot(in, fields, "alpha_u", 0.1f, range);
    const ColorSlot v = read_scalar_slot(in, fields, "alpha_v", 0.1f, range);
    material.alpha = u;
    const bool is_same = u.value == v.value && u.texture == v.texture;
    if (!is_same) {
      material.alpha.value = gray(std::sqrt(u.value.r * v.value.r));
      if (u.texture == kNone<TextureId>) material.alpha.texture = v.texture;
      fields.found().warning(
          fields.at("alpha_v"),
          fmt::format("alpha_u and alpha_v differ: rendered with {} in all directions", show(material.alpha.value.r)));
    }
  }
  material.alpha_v = material.alpha;
}

void read_conductor(Reader& in, Fields& fields, Material& material) {
  if (material.kind == BsdfKind::rough_conductor) read_roughness(in, fields, material);
  const std::string name = fields.text("material", "none");
  const float exterior = read_ior(fields, "ext_eta", 1);
  const bool has_index = fields.has("eta") || fields.has("k");
  if (has_index && name != "none") fields.error("material", "both material and eta, k are given; allowed: one of them");
  material.eta_metal = read_color(fields, "eta", gray(0), ColorUse::metal_index);
  material.k_metal = read_color(fields, "k", gray(1), ColorUse::metal_index);
  if (!has_index && name != "none") {
    if (const std::optional<ConductorIndex> metal = conductor_index(name)) {
      material.eta_metal = metal->eta, material.k_metal = metal->k;
    } else {
      fields.error("material", fmt::format("\"material\" is \"{}\"{}; allowed: {}", name,
                                           suggestion(name, conductor_names()), fmt::join(conductor_names(), ", ")));
    }
  }
  if (name != "none" || has_index) {
    material.eta_metal = material.eta_metal * (1 / exterior);
    material.k_metal = material.k_metal * (1 / exterior);
  }
  read_reflections(in, fields, material, false);
}

void read_plastic(Reader& in, Fields& fields, Material& material) {
  read_dielectric(fields, material, *dielectric_ior("polypropylene"));
  material.reflectance = read_slot(in, fields, "diffuse_reflectance", gray(0.5f), ColorUse::reflectance);
  material.nonlinear = fields.boolean("nonlinear", false);
  if (material.kind == BsdfKind::rough_plastic) read_roughness(in, fields, material);
  read_reflections(in, fields, material, false);
}

}  // namespace

}  // namespace myrialux::mitsuba
