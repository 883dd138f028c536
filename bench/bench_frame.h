// A scene with its receivers, lights, slices and tree, made once a program and shared by its benchmarks.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "myrialux/clusters/cut.h"
#include "myrialux/pipeline/clamp.h"
#include "myrialux/scene/load.h"

namespace myrialux::bench {

/// Entries of 1024 rows and 1000 clusters at this size fill some hundred slices.
inline constexpr int kWidth = 240, kHeight = 136, kSpp = 4;
inline constexpr std::uint64_t kLights = 100'000;

struct NamedScene {
  std::string name, path;
};

/// The scenes shipped and, where they are found, some of the shared ones: below MYRIALUX_SCENES, packed ones below
/// MYRIALUX_SCENES_UNPACKED.
inline std::vector<NamedScene> scenes() {
  std::vector<NamedScene> found;
  const auto add = [&](const std::filesystem::path& folder, const std::string& name) {
    for (const char* file : {"scene.xml", "scene_v3.xml"}) {
      std::error_code code;
      if (!std::filesystem::exists(folder / name / file, code)) continue;
      found.push_back({name, (folder / name / file).string()});
      return;
    }
  };
  for (const char* name : {"cornell-box", "living-room"}) add(MYRIALUX_SOURCE_DIR "/scenes", name);
  if (const char* folder = std::getenv("MYRIALUX_SCENES"))
    for (const char* name : {"veach-ajar", "staircase2"}) add(folder, name);
  if (const char* folder = std::getenv("MYRIALUX_SCENES_UNPACKED")) add(folder, "kitchen");
  return found;
}

/// Leaves solid meshes: what raw Embree can trace without callbacks.
inline Scene only_meshes(Scene scene) {
  std::erase_if(scene.placed,
                [&](ShapeId id) { return std::holds_alternative<Quadric>(scene.shapes[index(id)].geometry); });
  scene.instances.clear();
  for (Material& m : scene.materials) m.opacity = {gray(1)};
  return scene;
}

struct FrameParams {
  int width = kWidth, height = kHeight, spp = kSpp;
  std::uint64_t n_lights = kLights, seed = 1;
  std::uint32_t n_clusters = CutParams{}.n_clusters, n_rows = SliceParams{}.max_rows;
};

/// One pass over a scene up to its slices and light tree, as `myrialux render` makes it.
struct Frame {
  explicit Frame(Scene given, const FrameParams& p = {})
      : key{p.seed, 0},
        scene(std::move(given)),
        tracer(scene),
        emitters(scene, tracer.bounds()),
        world{.scene = scene,
              .tracer = tracer,
              .emitters = emitters,
              .max_depth = scene.max_depth,
              .rr_depth = scene.rr_depth},
        receivers(trace_receivers(world, {.width = p.width, .height = p.height, .spp = p.spp, .key = key}, progress)),
        lights(trace_lights(world, {.n_lights = p.n_lights, .key = key}, progress)),
        radius(0.5f * scene.bounds().diagonal()),
        slices(make_slices(receivers.receivers, radius, {.max_rows = p.n_rows})),
        tree(build_light_tree(world, lights.lights, radius, {.key = key})),
        cut{.n_clusters = p.n_clusters,
            .clamp_distance = clamp_length(0.02f, -1, size_points(receivers.receivers, p.spp))} {}
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  const Receivers& rows() const { return receivers.receivers; }
  std::vector<Column> columns(std::size_t s) const {
    return light_cut(world, rows(), slices.rows(s), lights.lights, tree, cut);
  }

  RandomKey key;
  Progress progress;
  Scene scene;
  Tracer tracer;
  Emitters emitters;
  World world;
  ReceiverResult receivers;
  LightResult lights;
  float radius;
  Slices slices;
  LightTree tree;
  CutParams cut;
};

/// The frame of a scene, without quadrics, instances and cut-outs, so that raw Embree sees the same surfaces; the one
/// asked for before is dropped, so register benchmarks scene by scene.
inline const Frame& frame(const NamedScene& scene) {
  static std::string held;
  static std::unique_ptr<Frame> made;
  if (held != scene.path) {
    made.reset();
    made = std::make_unique<Frame>(only_meshes(load_scene(scene.path)));
    held = scene.path;
  }
  return *made;
}

}  // namespace myrialux::bench
