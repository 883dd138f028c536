// Emitters of Mitsuba scenes.
#include <fmt/format.h>

#include <optional>

#include "myrialux/scene/mitsuba_reader.h"

namespace myrialux::mitsuba {

namespace {

const std::vector<std::string> kHere = {"area", "constant", "envmap", "point", "spot", "directional"};
const std::vector<std::string> kElsewhere = {"sunsky",          "sky",        "sun",        "timed_sunsky", "projector",
                                             "directionalarea", "collimated", "volumelight"};

std::string name_of(const Object& object) { return object.id.empty() ? object.spelled_type : object.id; }
std::optional<EnvmapEmitter> read_envmap(Reader& in, Fields& fields);
PointEmitter read_point(Fields& fields);
SpotEmitter read_spot(Reader& in, Fields& fields);
DirectionalEmitter read_directional(Fields& fields);
bool is_environment(const Emitter& emitter);

}  // namespace

void read_emitter(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  for (const Child& child : object.children)
    if (child.object && child.object->tag == "medium") child.used = true, read_medium(in, *child.object);
  Emitter emitter{name_of(object), object.at, ConstantEmitter{}};
  if (object.type == "constant") {
    emitter.kind = ConstantEmitter{read_color(fields, "radiance", gray(1), ColorUse::emission)};
  } else if (object.type == "envmap") {
    const std::optional<EnvmapEmitter> envmap = read_envmap(in, fields);
    if (!envmap) return;
    emitter.kind = *envmap;
  } else if (object.type == "point") {
    emitter.kind = read_point(fields);
  } else if (object.type == "spot") {
    emitter.kind = read_spot(in, fields);
  } else if (object.type == "directional") {
    emitter.kind = read_directional(fields);
  } else if (object.type == "area") {
    accept_all(object);
    return in.found.error(object.at, "emitter \"area\" stands in the scene itself; allowed: inside a shape");
  } else {
    in.has_unsupported_emitter = true;
    return report_type(in, object, kHere, kElsewhere);
  }
  fields.ignore({"sampling_weight"});
  fields.finish();
  if (is_environment(emitter))
    for (const Emitter& other : in.scene.emitters)
      if (is_environment(other))
        in.found.error(object.at, "a second environment; allowed: one. First at " + to_string(other.at));
  in.scene.emitters.push_back(std::move(emitter));
}

void read_area_emitter(Reader& in, const Object& object, ShapeId shape) {
  if (object.type != "area") {
    if (object.type == "directionalarea") in.has_unsupported_emitter = true;
    return report_type(in, object, {"area"}, {"directionalarea"});
  }
  Fields fields(object, in.found);
  for (const Child& child : object.children)
    if (child.object && child.object->tag == "medium") child.used = true, read_medium(in, *child.object);
  AreaEmitter area{shape, read_slot(in, fields, "radiance", gray(1), ColorUse::emission)};
  fields.ignore({"sampling_weight"});
  fields.finish();
  in.scene.emitters.push_back({name_of(object), object.at, area});
  in.scene.shapes[index(shape)].emitter = static_cast<EmitterId>(in.scene.emitters.size() - 1);
}

namespace {

bool is_environment(const Emitter& emitter) {
  return std::holds_alternative<ConstantEmitter>(emitter.kind) || std::holds_alternative<EnvmapEmitter>(emitter.kind);
}

std::optional<EnvmapEmitter> read_envmap(Reader& in, Fields& fields) {
  EnvmapEmitter envmap;
  const std::string path = read_filename(in, fields);
  envmap.scale = static_cast<float>(fields.number("scale", 1, {0, 1e30, false, "0 and above"}));
  envmap.to_world = fields.transform("to_world");
  fields.ignore({"mis_compensation", "cache", "gamma"});
  if (path.empty()) return {};
  Texture texture;
  texture.name = fields.text("filename", "");
  texture.image = in.assets.add_image(path, false, 0, fields.at("filename"));
  in.scene.textures.push_back(std::move(texture));
  envmap.image = static_cast<TextureId>(in.scene.textures.size() - 1);
  return envmap;
}

PointEmitter read_point(Fields& fields) {
  PointEmitter point;
  const Transform to_world = fields.transform("to_world");
  if (fields.has("position") && fields.has("to_world"))
    fields.error("position", "both position and to_world are given; allowed: one of them");
  point.position = fields.has("position") ? fields.vector("position", {}) : to_world.point({});
  point.intensity = read_color(fields, "intensity", gray(1), ColorUse::emission);
  return point;
}

SpotEmitter read_spot(Reader& in, Fields& fields) {
  SpotEmitter spot;
  spot.to_world = fields.transform("to_world");
  spot.intensity = read_color(fields, "intensity", gray(1), ColorUse::emission);
  spot.cutoff_deg =
      static_cast<float>(fields.number("cutoff_angle", 20, {0, 90, true, "greater than 0, at most 90 (degrees)"}));
  spot.beam_deg = static_cast<float>(fields.number("beam_width", spot.cutoff_deg * 0.75, {0, 90}));
  if (spot.beam_deg > spot.cutoff_deg)
    fields.error("beam_width", "the beam is wider than the cutoff angle; allowed: at most the cutoff angle");
  if (const Child* child = fields.child("texture"); child && child->object)
    spot.texture = read_texture(in, *child->object);
  return spot;
}

DirectionalEmitter read_directional(Fields& fields) {
  DirectionalEmitter light;
  const Transform to_world = fields.transform("to_world");
  if (fields.has("direction") && fields.has("to_world"))
    fields.error("direction", "both direction and to_world are given; allowed: one of them");
  const Vec3 direction = fields.has("direction") ? fields.vector("direction", {0, 0, 1}) : to_world.vector({0, 0, 1});
  if (length(direction) > 0)
    light.direction = normalize(direction);
  else
    fields.error("direction", "direction is 0; allowed: a vector of any length above 0");
  light.irradiance = read_color(fields, "irradiance", gray(1), ColorUse::emission);
  return light;
}

}  // namespace

}  // namespace myrialux::mitsuba
