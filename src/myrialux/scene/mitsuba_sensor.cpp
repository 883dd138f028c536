// Camera, film, reconstruction filter, sample count and path length limits of Mitsuba scenes.
#include <fmt/format.h>

#include <cmath>

#include "myrialux/math/rigid_motion.h"
#include "myrialux/scene/mitsuba_reader.h"
#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

namespace {

constexpr std::int64_t kMaxSide = 1 << 16, kMaxPixels = std::int64_t{1} << 28;

void read_film(Reader& in, const Object& object);
void read_filter(Reader& in, const Object& object);
void read_sampler(Reader& in, const Object& object);
double horizontal_fov_deg(Fields& fields, const FilmDescription& film);
void read_lens(Fields& fields, Camera& camera);
void read_placement(Fields& fields, Camera& camera);
void check_camera_scale(Fields& fields, const TextPosition& at, const Transform& to_world);

}  // namespace

void read_sensor(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  bool has_film = false, has_sampler = false;
  for (const Child& child : object.children) {
    if (!child.object) continue;
    const Object& part = *child.object;
    const auto only_once = [&](bool& has) {
      if (has) in.found.error(child.at, fmt::format("a second {}; allowed: one", part.tag));
      return !std::exchange(has, true);
    };
    if (part.tag == "film" || part.tag == "sampler" || part.tag == "medium") child.used = true;
    if (part.tag == "film" && only_once(has_film)) read_film(in, part);
    if (part.tag == "sampler" && only_once(has_sampler)) read_sampler(in, part);
    if (part.tag == "medium") read_medium(in, part);
  }
  const bool has_lens = object.type == "thinlens";
  if (!has_lens && object.type != "perspective") {
    report_type(in, object, {"perspective", "thinlens"},
                {"orthographic", "telecentric", "spherical", "batch", "distant", "radiancemeter", "fluencemeter",
                 "irradiancemeter", "radianceprobe", "hdistant", "mdistant", "perspective_rdist"});
    return;
  }
  Camera& camera = in.scene.camera;
  read_placement(fields, camera);
  camera.fov_x_deg = static_cast<float>(horizontal_fov_deg(fields, in.scene.film));
  camera.principal_x = static_cast<float>(fields.number("principal_point_offset_x", 0, {-100, 100}));
  camera.principal_y = static_cast<float>(fields.number("principal_point_offset_y", 0, {-100, 100}));
  const Range positive{0, 1e30, true, "greater than 0"};
  camera.near_clip = static_cast<float>(fields.number("near_clip", 1e-2, positive));
  camera.far_clip = static_cast<float>(fields.number("far_clip", 1e4, positive));
  if (!(camera.far_clip > camera.near_clip))
    fields.error("far_clip",
                 fmt::format("far clip {} must exceed near clip {}", show(camera.far_clip), show(camera.near_clip)));
  if (has_lens) read_lens(fields, camera);
  fields.ignore({"focus_distance", "srf"});
  fields.finish();
}

void read_integrator(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  for (const Child& child : object.children)  // moment, aov: the one inside tells
    if (child.object && child.object->tag == "integrator") {
      child.used = true;
      read_integrator(in, *child.object);
      accept_all(object);
      return;
    }
  in.scene.max_depth = static_cast<int>(fields.integer("max_depth", -1, -1, 1 << 30));
  in.scene.rr_depth = static_cast<int>(fields.integer("rr_depth", 5, 1, 1 << 30));
  in.scene.hide_emitters = fields.boolean("hide_emitters", false);
  if (object.type == "direct" && !fields.has("max_depth")) in.scene.max_depth = 2;
  const bool keeps_meaning = object.type == "path" || object.type == "volpath" || object.type == "volpathmis" ||
                             object.type == "direct" || object.type == "myrialux" || object.type == "volpath_simple";
  if (!keeps_meaning)
    in.found.warning(object.at, fmt::format("integrator \"{}\" is not followed: --method chooses how light is computed",
                                            object.spelled_type));
  accept_all(object);
}

namespace {

/// Degrees between the left and the right border of the film.
double horizontal_fov_deg(Fields& fields, const FilmDescription& film) {
  const double aspect = static_cast<double>(film.width) / film.height;
  const double radians = 3.14159265358979323846 / 180;
  std::string axis = fields.choice("fov_axis", "x", {"x", "y", "diagonal", "smaller", "larger"});
  double fov = 0;
  if (fields.has("fov")) {
    if (fields.has("focal_length"))
      fields.error("focal_length", "both fov and focal_length are given; allowed: one of them");
    fields.ignore({"focal_length"});
    fov = fields.number("fov", 45, {1e-4, 179.999, false, "greater than 0, less than 180 (degrees)"});
  } else {
    std::string text = fields.text("focal_length", "50mm");
    if (text.ends_with("mm")) text.resize(text.size() - 2);
    const std::optional<double> focal_mm = parse_number(text);
    if (!focal_mm || !(*focal_mm > 0))
      fields.error("focal_length",
                   fmt::format("focal length is \"{}\"; allowed: millimetres above 0, such as \"50mm\"", text));
    // 35 mm film: 36 mm x 24 mm; the number means the diagonal
    fov = 2 * std::atan(0.5 * std::hypot(36.0, 24.0) / (focal_mm && *focal_mm > 0 ? *focal_mm : 50)) / radians;
    axis = "diagonal";
  }
  if (axis == "smaller") axis = aspect > 1 ? "y" : "x";
  if (axis == "larger") axis = aspect > 1 ? "x" : "y";
  if (axis == "x") return fov;
  const double half = std::tan(0.5 * fov * radians);  // half extent at distance 1
  const double half_x = axis == "y" ? half * aspect : half / std::hypot(1.0, 1 / aspect);
  return 2 * std::atan(half_x) / radians;
}

void read_lens(Fields& fields, Camera& camera) {
  if (!fields.has("aperture_radius"))
    fields.error("aperture_radius", "sensor \"thinlens\" needs an aperture_radius, 0 and above (scene units)");
  camera.aperture_radius = static_cast<float>(fields.number("aperture_radius", 0, {0, 1e30, false, "0 and above"}));
  const Range positive{0, 1e30, true, "greater than 0"};
  camera.focus_distance =
      static_cast<float>(fields.number("focus_distance", static_cast<double>(camera.far_clip), positive));
}

/// Where the camera stands, or its keyframes and shutter; then to_world is the middle of what the shutter shows.
void read_placement(Fields& fields, Camera& camera) {
  camera.shutter_open = fields.number("shutter_open", 0), camera.shutter_close = fields.number("shutter_close", 0);
  if (camera.shutter_close < camera.shutter_open)
    fields.error("shutter_close",
                 fmt::format("the shutter closes at {} but opens at {}; allowed: the same time or later",
                             show(camera.shutter_close), show(camera.shutter_open)));
  const Property* property = fields.property("to_world");
  const Animation* animation = property ? std::get_if<Animation>(&property->value) : nullptr;
  if (!animation) {
    camera.to_world = fields.transform("to_world");
    check_camera_scale(fields, fields.at("to_world"), camera.to_world);
    if (camera.shutter_close > camera.shutter_open)
      fields.found().warning(fields.at("shutter_close"), "the shutter changes nothing: nothing moves");
    return;
  }
  const Animation::Key& first = animation->keys.front();
  if (animation->keys.size() == 1)
    fields.found().error(first.at, "the only keyframe of an animation; allowed: two and more");
  for (const Animation::Key& key : animation->keys) {
    check_camera_scale(fields, key.at, key.to_world);
    if (!camera.motion.empty() && !(key.time > camera.motion.back().time))
      fields.found().error(key.at, fmt::format("keyframe of time {} after that of time {}; allowed: times that rise",
                                               show(key.time), show(camera.motion.back().time)));
    if (key.to_world.determinant3() * first.to_world.determinant3() < 0)
      fields.found().error(key.at, "one keyframe is mirrored, the first is not, or the reverse; allowed: all or none");
    camera.motion.push_back({key.time, key.to_world});
  }
  camera.to_world = camera.at(0.5 * (camera.shutter_open + camera.shutter_close));
  if (camera.shutter_close == camera.shutter_open)
    fields.found().warning(property->at, fmt::format("the camera is seen where it stands at time {} only: the shutter "
                                                     "opens and closes then",
                                                     show(camera.shutter_open)));
}

void check_camera_scale(Fields& fields, const TextPosition& at, const Transform& to_world) {
  const auto& m = to_world.rows();
  for (int c = 0; c < 3; ++c)
    if (const double length = std::sqrt(m[c] * m[c] + m[4 + c] * m[4 + c] + m[8 + c] * m[8 + c]);
        std::abs(length - 1) > 1e-3) {
      fields.found().error(
          at, fmt::format("the camera is scaled by {}; allowed: rotations, translations, mirrors", show(length)));
      return;
    }
  if (rigidity_error(to_world) > 5e-3)
    fields.found().error(at, "the camera is sheared; allowed: rotations, translations, mirrors");
}

void read_film(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  FilmDescription& film = in.scene.film;
  bool has_filter = false;
  for (const Child& child : object.children)
    if (child.object && child.object->tag == "rfilter") {
      child.used = true;
      if (std::exchange(has_filter, true)) in.found.error(child.at, "a second rfilter; allowed: one");
      read_filter(in, *child.object);
    }
  if (object.type != "hdrfilm" && object.type != "ldrfilm")
    return report_type(in, object, {"hdrfilm", "ldrfilm"}, {"specfilm", "mfilm", "tiledhdrfilm"});
  film.width = static_cast<int>(fields.integer("width", 768, 1, kMaxSide));
  film.height = static_cast<int>(fields.integer("height", 576, 1, kMaxSide));
  if (std::int64_t{film.width} * film.height > kMaxPixels) {
    in.found.error(object.at,
                   fmt::format("film of {} x {} pixels; allowed: at most 2^28 pixels", film.width, film.height));
    film.width = film.height = 1;
  }
  for (const std::string name : {"crop_width", "crop_height", "crop_offset_x", "crop_offset_y"})
    if (fields.has(name)) {
      in.found.unsupported(fields.at(name),
                           fmt::format("film: \"{}\" cannot be rendered yet; the whole film is", name));
      fields.ignore({name});
    }
  fields.ignore({"file_format", "pixel_format", "component_format", "banner", "high_quality_edges", "sample_border",
                 "attach_log", "gamma", "exposure", "tonemap_method", "key", "burn", "compensate", "label"});
  fields.finish();
}

void read_filter(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  Filter& filter = in.scene.film.filter;
  const Range positive{0, 64, true, "greater than 0, at most 64 (pixels)"};
  const auto number = [&](const char* name, double missing) {
    return static_cast<float>(fields.number(name, missing, positive));
  };
  if (object.type == "box") {
    filter = {Filter::Kind::box, number("radius", 0.5)};
  } else if (object.type == "tent") {
    filter = {Filter::Kind::tent, number("radius", 1)};
  } else if (object.type == "gaussian") {
    filter = {Filter::Kind::gaussian, 0, number("stddev", 0.5)};
    filter.radius = number("radius", 4 * static_cast<double>(filter.sigma));
  } else if (object.type == "mitchell") {
    filter = {Filter::Kind::mitchell, number("radius", 2)};
    const char* b = fields.has("b") ? "b" : "B";
    const char* c = fields.has("c") ? "c" : "C";
    filter.b = static_cast<float>(fields.number(b, 1.0 / 3, {-10, 10}));
    filter.c = static_cast<float>(fields.number(c, 1.0 / 3, {-10, 10}));
  } else if (object.type == "catmullrom") {
    filter = {Filter::Kind::catmullrom, number("radius", 2), 0.5f, 0, 0.5f};
  } else if (object.type == "lanczos") {
    filter = {Filter::Kind::lanczos, static_cast<float>(fields.integer("lobes", 3, 1, 64))};
  } else {
    return report_type(in, object, {"box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"}, {});
  }
  fields.finish();
}

void read_sampler(Reader& in, const Object& object) {
  Fields fields(object, in.found);
  in.scene.film.spp = static_cast<int>(fields.integer("sample_count", 4, 1, 1 << 30));
  accept_all(object);  // every sampler is accepted: ours is used
}

}  // namespace

}  // namespace myrialux::mitsuba
