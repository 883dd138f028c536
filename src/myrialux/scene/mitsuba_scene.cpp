// Walks over the top of a Mitsuba scene and hands each object to its reader.
#include "myrialux/scene/mitsuba_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "myrialux/scene/mitsuba_reader.h"

namespace myrialux::mitsuba {

namespace {

void read_top(Reader& in, const Child& child, bool& has_sensor, bool& has_integrator);

}  // namespace

void read_scene(const std::string& path, const LoadOptions& options, Scene& scene, AssetJobs& assets, std::string& text,
                Diagnostics& found) {
  const Tree tree = read_tree(path, options, found);
  for (const std::string& part : tree.texts) text += part;
  if (tree.texts.empty()) return;  // nothing could be read
  Reader in{tree, scene, found, assets};
  bool has_sensor = false, has_integrator = false;
  // Groups first: instances may come before the group they name.
  for (const bool groups : {true, false})
    for (const Child& child : tree.scene().children)
      if (child.object && (child.object->tag == "shape" && child.object->type == "shapegroup") == groups)
        read_top(in, child, has_sensor, has_integrator);
  for (const Property& p : tree.scene().properties)
    found.warning(p.at, fmt::format("the scene does not know the parameter \"{}\"", p.spelled));
  // What is missing is told only where the rest could be read: it may sit behind another mistake.
  if (found.has(Severity::error)) return;
  if (!has_sensor) found.error(tree.scene().at, "the scene has no sensor; add <sensor type=\"perspective\">");
  if (scene.emitters.empty() && !in.has_unsupported_emitter)
    found.error(tree.scene().at, "the scene has no light; add an <emitter>, on a shape or in the scene");
}

void report_type(Reader& in, const Object& object, std::vector<std::string> here,
                 const std::vector<std::string>& elsewhere) {
  accept_all(object);
  if (object.type.empty()) return;  // told while the tree was read
  const std::string allowed = here.empty() ? "" : fmt::format("; allowed: {}", fmt::join(here, ", "));
  if (std::find(elsewhere.begin(), elsewhere.end(), object.type) != elsewhere.end()) {
    in.found.unsupported(object.at,
                         fmt::format("{} \"{}\" cannot be rendered yet{}", object.tag, object.spelled_type, allowed));
    return;
  }
  std::vector<std::string> all = here;
  all.insert(all.end(), elsewhere.begin(), elsewhere.end());
  in.found.error(object.at, fmt::format("unknown {} \"{}\"{}{}", object.tag, object.spelled_type,
                                        suggestion(object.type, all), allowed));
}

void read_medium(Reader& in, const Object& object) {
  if (!in.reported_media.insert(&object).second) return;
  accept_all(object);
  report_type(in, object, {}, {"homogeneous", "heterogeneous"});
}

namespace {

void read_top(Reader& in, const Child& child, bool& has_sensor, bool& has_integrator) {
  child.used = true;
  const Object& object = *child.object;
  const auto only_once = [&](bool& has) {
    if (has) in.found.error(object.at, fmt::format("a second {}; allowed: one", object.tag));
    return !std::exchange(has, true);
  };
  if (object.tag == "shape") {
    read_shape(in, object);
  } else if (object.tag == "bsdf") {
    read_material(in, object);
  } else if (object.tag == "texture") {
    if (object.type != "scale") read_texture(in, object);
  } else if (object.tag == "emitter") {
    read_emitter(in, object);
  } else if (object.tag == "sensor") {
    if (only_once(has_sensor)) read_sensor(in, object);
  } else if (object.tag == "integrator") {
    if (only_once(has_integrator)) read_integrator(in, object);
  } else if (object.tag == "medium") {
    read_medium(in, object);
  } else if (object.tag == "phase" || object.tag == "volume") {
    accept_all(object);  // of use only where a medium names it
  } else {
    in.found.error(object.at,
                   fmt::format("<{}> stands in the scene itself; allowed: bsdf, emitter, integrator, medium, "
                               "sensor, shape, texture",
                               object.tag));
  }
}

}  // namespace

}  // namespace myrialux::mitsuba
