// myrialux info: what is in a scene, for people or as JSON.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "myrialux/base/parallel.h"
#include "scene_options.h"

namespace myrialux::app {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(BsdfKind kind) {
  switch (kind) {
    case BsdfKind::diffuse:
      return "diffuse";
    case BsdfKind::conductor:
      return "conductor";
    case BsdfKind::rough_conductor:
      return "roughconductor";
    case BsdfKind::plastic:
      return "plastic";
    case BsdfKind::rough_plastic:
      return "roughplastic";
    case BsdfKind::blinn_phong:
      return "Blinn-Phong";
    case BsdfKind::dielectric:
      return "dielectric";
    case BsdfKind::thin_dielectric:
      return "thindielectric";
    case BsdfKind::rough_dielectric:
      return "roughdielectric";
    case BsdfKind::null:
      return "null";
  }
  return "?";
}

const char* name_of(Filter::Kind kind) {
  constexpr const char* kNames[] = {"box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* name_of(const Emitter& emitter) {
  constexpr const char* kNames[] = {"area", "constant", "envmap", "point", "spot", "directional"};
  return kNames[emitter.kind.index()];
}

Json array(Vec3 v) { return Json::array({v.x, v.y, v.z}); }

Json texture_json(const Texture& t) {
  Json j = {{"name", t.name}, {"kind", t.kind == Texture::Kind::bitmap ? "bitmap" : "checkerboard"}};
  if (t.image) j["size"] = {t.image->width, t.image->height};
  return j;
}

template <class Things, class Name>
Json count_by(const Things& things, const Name& name) {
  std::map<std::string, std::size_t> counts;
  for (const auto& thing : things) ++counts[name(thing)];
  return Json(counts);
}

Json messages(const Scene& scene, Severity severity) {
  Json list = Json::array();
  for (const Diagnostic& d : scene.diagnostics)
    if (d.severity == severity) list.push_back(to_string(d));
  return list;
}

Json describe(const Scene& scene) {
  const Box3 box = scene.bounds();
  Json textures = Json::array();
  for (const Texture& t : scene.textures) textures.push_back(texture_json(t));
  const Transform& view = scene.camera.to_world;
  return {{"scene", scene.path},
          {"sha256", scene.sha256},
          {"shapes", scene.shapes.size()},
          {"meshes", scene.meshes.size()},
          {"triangles", scene.n_triangles()},
          {"dropped_triangles", scene.dropped_triangles},
          {"instances", scene.instances.size()},
          {"groups", scene.groups.size()},
          {"materials", count_by(scene.materials, [](const Material& m) { return name_of(m.kind); })},
          {"textures", textures},
          {"lights", count_by(scene.emitters, [](const Emitter& e) { return name_of(e); })},
          {"camera",
           {{"origin", array(view.point({0, 0, 0}))},
            {"direction", array(normalize(view.vector({0, 0, 1})))},
            {"up", array(normalize(view.vector({0, 1, 0})))},
            {"fov_x_deg", scene.camera.fov_x_deg},
            {"aperture_radius", scene.camera.aperture_radius},
            {"focus_distance", scene.camera.aperture_radius > 0 ? Json(scene.camera.focus_distance) : Json(nullptr)},
            {"keyframes", scene.camera.motion.size()},
            {"shutter", {scene.camera.shutter_open, scene.camera.shutter_close}}}},
          {"film",
           {{"width", scene.film.width},
            {"height", scene.film.height},
            {"spp", scene.film.spp},
            {"filter", name_of(scene.film.filter.kind)}}},
          {"max_depth", scene.max_depth},
          {"bounds", box.is_empty() ? Json(nullptr) : Json{{"lower", array(box.lower)}, {"upper", array(box.upper)}}},
          {"warnings", messages(scene, Severity::warning)},
          {"unsupported", messages(scene, Severity::unsupported)}};
}

std::string counts(const Json& by_kind) {
  std::size_t sum = 0;
  std::string list;
  for (const auto& [kind, n] : by_kind.items()) {
    sum += n.get<std::size_t>();
    list += fmt::format("{}{} {}", list.empty() ? ": " : ", ", n.get<std::size_t>(), kind);
  }
  return std::to_string(sum) + list;
}

std::string show(const Json& vector) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", vector[0].get<double>(), vector[1].get<double>(),
                     vector[2].get<double>());
}

void print(const Json& j) {
  const auto row = [](const char* name, const std::string& text) { fmt::print("{:<11}{}\n", name, text); };
  row("scene", j["scene"].get<std::string>());
  row("shapes",
      fmt::format("{} ({} meshes), {} instances of {} groups", j["shapes"].get<std::size_t>(),
                  j["meshes"].get<std::size_t>(), j["instances"].get<std::size_t>(), j["groups"].get<std::size_t>()));
  const auto dropped = j["dropped_triangles"].get<std::uint64_t>();
  row("triangles", fmt::format("{}{}", j["triangles"].get<std::uint64_t>(),
                               dropped > 0 ? fmt::format(" ({} without area left out)", dropped) : ""));
  row("materials", counts(j["materials"]));
  row("textures", std::to_string(j["textures"].size()));
  row("lights", counts(j["lights"]));
  const Json& camera = j["camera"];
  std::string lens;
  if (const double radius = camera["aperture_radius"].get<double>(); radius > 0)
    lens = fmt::format(", lens of radius {:.4g} focused at {:.4g}", radius, camera["focus_distance"].get<double>());
  if (const auto n = camera["keyframes"].get<std::size_t>(); n > 0)
    lens += fmt::format(", moved by {} keyframes, shutter from {:.6g} to {:.6g}", n, camera["shutter"][0].get<double>(),
                        camera["shutter"][1].get<double>());
  row("camera", fmt::format("at {} looking along {}, {:.4g} degrees wide{}", show(camera["origin"]),
                            show(camera["direction"]), camera["fov_x_deg"].get<double>(), lens));
  const Json& film = j["film"];
  const int depth = j["max_depth"].get<int>();
  row("film", fmt::format("{}x{} pixels, {} samples each, {} filter, paths of {} edges", film["width"].get<int>(),
                          film["height"].get<int>(), film["spp"].get<int>(), film["filter"].get<std::string>(),
                          depth < 0 ? "any number of" : "at most " + std::to_string(depth)));
  const Json& bounds = j["bounds"];
  row("bounds", bounds.is_null() ? "empty" : show(bounds["lower"]) + " to " + show(bounds["upper"]));
  for (const auto& text : j["warnings"]) fmt::print("{}\n", text.get<std::string>());
  for (const auto& text : j["unsupported"]) fmt::print("cannot be rendered: {}\n", text.get<std::string>());
}

}  // namespace

void add_info(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("info", "Tell what is in a scene");
  auto options = std::make_shared<SceneOptions>();
  auto as_json = std::make_shared<bool>(false);
  add_scene_arguments(command, *options);
  command.add_flag("--json", *as_json, "Print JSON");
  command.footer(R"(Examples:
  myrialux info room.xml
  myrialux info room.xml --json | jq .triangles)");
  command.callback([=, &session] {
    session.run = [=] {
      const Definitions definitions = sort_definitions(*options);
      const ThreadScope threads(thread_count(*options));
      const Json j = describe(load_scene(options->path, {.defines = definitions.scene, .strict = options->strict}));
      if (*as_json)
        fmt::print("{}\n", j.dump(2, ' ', false, Json::error_handler_t::replace));
      else
        print(j);
    };
  });
}

}  // namespace myrialux::app
