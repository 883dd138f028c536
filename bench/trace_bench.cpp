// Occlusion rays per second: 16 adjacent points towards one light, by Tracer's packets and by Embree on the same rays.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/base/rng.h"
#include "myrialux/math/warp.h"
#include "myrialux/scene/load.h"
#include "myrialux/trace/embree.h"
#include "myrialux/trace/tracer.h"

namespace myrialux {
namespace {

/// Two rows of round columns under a vault of beams in a closed hall: about 60 000 triangles.
Scene colonnade() {
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  const auto quad = [&](Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3 p : {a, b, c, d}) mesh.positions.push_back(p);
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + k);
  };
  const auto box = [&](Vec3 l, Vec3 u) {
    quad({l.x, l.y, l.z}, {u.x, l.y, l.z}, {u.x, u.y, l.z}, {l.x, u.y, l.z});
    quad({l.x, l.y, u.z}, {u.x, l.y, u.z}, {u.x, u.y, u.z}, {l.x, u.y, u.z});
    quad({l.x, l.y, l.z}, {l.x, u.y, l.z}, {l.x, u.y, u.z}, {l.x, l.y, u.z});
    quad({u.x, l.y, l.z}, {u.x, u.y, l.z}, {u.x, u.y, u.z}, {u.x, l.y, u.z});
    quad({l.x, l.y, l.z}, {u.x, l.y, l.z}, {u.x, l.y, u.z}, {l.x, l.y, u.z});
    quad({l.x, u.y, l.z}, {u.x, u.y, l.z}, {u.x, u.y, u.z}, {l.x, u.y, u.z});
  };
  constexpr int kColumns = 12, kAround = 48, kUp = 24;
  box({-10, 0, -30}, {10, 9, 30});
  for (int k = 0; k < 2 * kColumns; ++k) {
    const Vec3 base{k % 2 ? 5.0f : -5.0f, 0, -27.5f + 5.0f * static_cast<float>(k / 2)};
    const auto at = [&](int around, int up) {
      const float phi = 2 * kPi * static_cast<float>(around) / kAround, y = 7.5f * static_cast<float>(up) / kUp;
      const float r = 0.6f + 0.25f * std::pow(std::fabs(y / 3.75f - 1), 6.0f);
      return base + Vec3{r * std::cos(phi), y, r * std::sin(phi)};
    };
    for (int i = 0; i < kAround; ++i)
      for (int j = 0; j < kUp; ++j) quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    box(base + Vec3{-1, 7.5f, -1}, base + Vec3{1, 8, 1});
    box({-10, 8, base.z - 0.3f}, {10, 8.6f, base.z + 0.3f});
  }
  scene.meshes.push_back(std::move(mesh));
  Shape shape;
  shape.geometry = static_cast<MeshId>(0);
  shape.material = static_cast<MaterialId>(0);
  scene.shapes.push_back(shape);
  scene.placed.push_back(static_cast<ShapeId>(0));
  scene.camera.to_world = Transform::look_at({0, 2, -29}, {1, 2.5f, 0}, {0, 1, 0});
  scene.camera.fov_x_deg = 70;
  return scene;
}

/// Packets of 16 segments: neighbouring pixels of a 4 x 4 tile towards one point on a surface.
struct Work {
  explicit Work(Scene made) : scene(std::move(made)), tracer(scene) {
    constexpr std::size_t kPackets = 4096;
    Rng rng({1, 0}, Stage::test, 0);
    const float half = std::tan(scene.camera.fov_x_deg * kPi / 360);
    while (packets.size() < kPackets) {
      const float cx = 2 * rng.next() - 1, cy = 1.2f * rng.next() - 0.6f;
      const auto light = tracer.closest(from_camera(half, 2 * rng.next() - 1, 1.2f * rng.next() - 0.6f));
      if (!light) continue;
      Vec3 bounce = sample_sphere({rng.next(), rng.next()});
      const Vec3 start = offset_origin(light->p, light->ng, light->offset, bounce);
      const auto end = tracer.closest({start, bounce});
      if (!end) continue;
      Segments<16> s;
      bool complete = true;
      for (int k = 0; k < 16 && complete; ++k) {
        const auto p = tracer.closest(from_camera(half, cx + 0.003f * float(k % 4), cy + 0.003f * float(k / 4)));
        complete = p.has_value();
        if (!complete) break;
        const Vec3 d = end->p - p->p, a = offset_origin(p->p, p->ng, p->offset, d),
                   b = offset_origin(end->p, end->ng, end->offset, -d);
        s.from_x[k] = a.x, s.from_y[k] = a.y, s.from_z[k] = a.z, s.to_x[k] = b.x, s.to_y[k] = b.y, s.to_z[k] = b.z;
      }
      if (complete) packets.push_back(s);
    }
    for (const Segments<16>& s : packets) {
      RTCRay16 r{};
      for (int k = 0; k < 16; ++k) {
        r.org_x[k] = s.from_x[k], r.org_y[k] = s.from_y[k], r.org_z[k] = s.from_z[k];
        r.dir_x[k] = s.to_x[k] - s.from_x[k], r.dir_y[k] = s.to_y[k] - s.from_y[k];
        r.dir_z[k] = s.to_z[k] - s.from_z[k], r.tfar[k] = 1 - 0x1p-20f, r.mask[k] = 0xffffffffu;
      }
      rays.push_back(r);
    }
  }
  Ray from_camera(float half, float x, float y) const {
    const Transform& m = scene.camera.to_world;
    return {m.point({}), normalize(m.vector({x * half, y * half, 1}))};
  }
  Scene scene;
  Tracer tracer;
  std::vector<Segments<16>> packets;
  std::vector<RTCRay16> rays;
};

const Work* work(int which) {
  static const std::unique_ptr<Work> hall = std::make_unique<Work>(colonnade());
  if (which == 0) return hall.get();
  static const std::unique_ptr<Work> stairs = []() -> std::unique_ptr<Work> {
    const char* folder = std::getenv("MYRIALUX_SCENES");
    if (!folder) return nullptr;
    for (const char* name : {"staircase2/scene_v3.xml", "staircase2/scene.xml"})
      if (std::filesystem::exists(std::filesystem::path(folder) / name))
        return std::make_unique<Work>(bench::only_meshes(load_scene((std::filesystem::path(folder) / name).string())));
    return nullptr;
  }();
  return stairs.get();
}

std::uint64_t embree_all(const Work& w) {
  std::uint64_t blocked = 0;
  alignas(64) const int valid[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
  for (const RTCRay16& filled : w.rays) {
    RTCRay16 r = filled;  // tfar is overwritten
    EmbreeContext context;
    init_context(context);
    embree_occluded<16>(valid, static_cast<RTCScene>(w.tracer.native_scene()), context, r, true);
    for (int k = 0; k < 16; ++k) blocked += r.tfar[k] < 0;
  }
  return blocked;
}
std::uint64_t packets_16(const Work& w) {
  std::uint64_t blocked = 0;
  for (const Segments<16>& s : w.packets)
    blocked += static_cast<std::uint64_t>(__builtin_popcount(w.tracer.occluded_packet(s, 0xffff, true)));
  return blocked;
}
template <int N>
std::uint64_t packets_of(const Work& w) {
  std::uint64_t blocked = 0;
  for (const Segments<16>& s : w.packets)
    for (int first = 0; first < 16; first += N) {
      Segments<N> part;
      for (int k = 0; k < N; ++k) {
        part.from_x[k] = s.from_x[first + k], part.from_y[k] = s.from_y[first + k];
        part.from_z[k] = s.from_z[first + k], part.to_x[k] = s.to_x[first + k];
        part.to_y[k] = s.to_y[first + k], part.to_z[k] = s.to_z[first + k];
      }
      blocked += static_cast<std::uint64_t>(__builtin_popcount(w.tracer.occluded_packet(part, (1u << N) - 1, true)));
    }
  return blocked;
}
std::uint64_t singles(const Work& w) {
  std::uint64_t blocked = 0;
  for (const Segments<16>& s : w.packets)
    for (int k = 0; k < 16; ++k)
      blocked += w.tracer.occluded({s.from_x[k], s.from_y[k], s.from_z[k]}, {s.to_x[k], s.to_y[k], s.to_z[k]});
  return blocked;
}

/// Thread CPU time of `body` and of raw Embree, in turn within one process, so that their ratio stands load.
void compare(benchmark::State& state, std::uint64_t (*body)(const Work&)) {
  const Work* w = work(static_cast<int>(state.range(0)));
  if (!w) {
    state.SkipWithError("staircase2 not found; set MYRIALUX_SCENES to the folder of the shared scenes");
    return;
  }
  double own_s = 0, raw_s = 0;
  std::uint64_t n = 0, blocked = 0;
  for ([[maybe_unused]] auto _ : state) {
    ThreadStopwatch watch;
    blocked += body(*w);
    own_s += watch.lap();
    benchmark::DoNotOptimize(embree_all(*w));
    raw_s += watch.lap();
    n += 16 * w->packets.size();
  }
  state.counters["Mrays/s"] = 1e-6 * static_cast<double>(n) / own_s;
  state.counters["embree16_Mrays/s"] = 1e-6 * static_cast<double>(n) / raw_s;
  state.counters["ratio_to_embree16"] = raw_s / own_s;
  state.counters["blocked"] = static_cast<double>(blocked) / static_cast<double>(n);
}

BENCHMARK_CAPTURE(compare, packets_of_16, packets_16)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compare, packets_of_8, packets_of<8>)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compare, packets_of_4, packets_of<4>)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compare, single, singles)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace myrialux
