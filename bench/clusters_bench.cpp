// Times of slices, light tree and cut on a synthetic room: receivers by pixel on the walls and a ball, lights strewn.
#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

#include "myrialux/base/process.h"
#include "myrialux/clusters/agglomerative_tree.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/math/warp.h"

namespace myrialux {
namespace {

struct SurfaceSample {
  Vec3 p, n;
};

/// A place on the walls of the box [-1, 1]^3 or on a ball of radius 0.4 within.
SurfaceSample sample_room(Rng& rng) {
  const Vec2 u{rng.next(), rng.next()};
  if (rng.next() < 0.3f) {
    const Vec3 n = sample_sphere(u);
    return {Vec3{0.2f, -0.4f, 0.1f} + n * 0.4f, n};
  }
  const auto axis = static_cast<int>(rng.below(3));
  const float side = rng.below(2) ? 1.0f : -1.0f;
  SurfaceSample s{};
  s.p[axis] = side, s.p[(axis + 1) % 3] = 2 * u.x - 1, s.p[(axis + 2) % 3] = 2 * u.y - 1;
  s.n[axis] = -side;
  return s;
}

constexpr float kRadius = 1.8f;

/// One diffuse material, one lamp: what a World needs to exist.
Scene make_scene() {
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  scene.meshes.push_back(mesh);
  Shape shape;
  shape.geometry = MeshId{0};
  shape.material = MaterialId{0};
  shape.emitter = EmitterId{0};
  scene.shapes.push_back(shape);
  scene.placed.push_back(ShapeId{0});
  Emitter emitter;
  emitter.kind = AreaEmitter{ShapeId{0}, {gray(1)}};
  scene.emitters.push_back(emitter);
  return scene;
}

struct Room {
  Scene scene = make_scene();
  Tracer tracer{scene};
  Emitters emitters{scene, tracer.bounds()};
  World world() const { return {.scene = scene, .tracer = tracer, .emitters = emitters}; }
};

Receivers make_receivers(std::size_t n) {
  Receivers r;
  r.reserve(n);
  Rng rng({1}, Stage::test, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const SurfaceSample s = sample_room(rng);
    r.p.push_back(s.p), r.n.push_back(s.n), r.ng.push_back(s.n), r.wo.push_back(s.n);
    r.bsdf.push_back({.material = MaterialId{0}, .alpha = 0, .reflectance = gray(0.5f), .specular = {}});
    r.inside.push_back(0);
  }
  return r;
}

VirtualLights make_lights(std::size_t n) {
  VirtualLights l;
  Rng rng({2}, Stage::test, 0);
  for (std::size_t j = 0; j < n; ++j) {
    const SurfaceSample s = sample_room(rng);
    l.p.push_back(s.p), l.n.push_back(s.n), l.ng.push_back(s.n), l.offset.push_back(0);
    l.light.push_back(gray(rng.next() + 0.1f));
    l.kind.push_back(LightKind::oriented);
    l.bounce.push_back(1), l.extra.push_back(0xffffffffu);
  }
  return l;
}

void slices(benchmark::State& state) {
  const Receivers receivers = make_receivers(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(make_slices(receivers, kRadius, {}));
}
BENCHMARK(slices)->Arg(100'000)->Arg(3'600'000)->Unit(benchmark::kMillisecond)->UseRealTime();

/// A number of /proc/self/status, MiB.
double status_mib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) / 1024;
  return 0;
}

/// Builds trees of so many lights. Counters, MiB: the tree itself, and the peak while it is built.
template <class Build>
void measure_tree(benchmark::State& state, const Build& build) {
  const Room room;
  const VirtualLights lights = make_lights(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(build(room.world(), lights));

  release_freed_memory();
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew
  const double before = status_mib("VmRSS");
  const LightTree tree = build(room.world(), lights);
  state.counters["peak_MiB"] = status_mib("VmHWM") - before;
  state.counters["tree_MiB"] = static_cast<double>(tree.memory_bytes()) / (1 << 20);
}

void light_tree(benchmark::State& state) {
  measure_tree(state, [](const World& world, const VirtualLights& lights) {
    return build_light_tree(world, lights, kRadius, {});
  });
}
BENCHMARK(light_tree)
    ->RangeMultiplier(10)
    ->Range(10'000, 10'000'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()  // of all threads
    ->UseRealTime();

/// Arguments: lights, groups that compete.
void agglomerative_tree(benchmark::State& state) {
  const auto n_competing = static_cast<std::uint32_t>(state.range(1));
  measure_tree(state, [=](const World& world, const VirtualLights& lights) {
    return build_agglomerative_tree(world, lights, kRadius, {.n_competing = n_competing, .key = {}});
  });
}
BENCHMARK(agglomerative_tree)
    ->ArgsProduct({{10'000, 100'000, 1'000'000, 10'000'000}, {32}})
    ->Args({1'000'000, 8})
    ->Args({1'000'000, 16})
    ->Args({1'000'000, 64})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// Arguments: clusters, points (0: all 1024). One thread; a slice an iteration.
void cut(benchmark::State& state) {
  const Room room;
  const Receivers receivers = make_receivers(1 << 18);
  const Slices all = make_slices(receivers, kRadius, {});
  const VirtualLights lights = make_lights(100'000);
  const LightTree tree = build_light_tree(room.world(), lights, kRadius, {});
  const CutParams params{.n_clusters = static_cast<std::uint32_t>(state.range(0)),
                         .n_points = static_cast<std::uint32_t>(state.range(1)),
                         .clamp_distance = 0.05f};
  std::size_t s = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(light_cut(room.world(), receivers, all.rows(s++ % all.size()), lights, tree, params));
}
BENCHMARK(cut)->Args({250, 16})->Args({1000, 16})->Args({2000, 16})->Args({1000, 0})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace myrialux
