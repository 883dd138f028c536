// Pairs of rows and lights shaded a second by one thread, for slices of 1024 rows x 1000 columns with random
// visibility: diffuse, rough plastic and mixed rows, on every instruction set of this machine. Building of flat arrays
// included.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "myrialux/kernels/isa.h"
#include "myrialux/shading/shade.h"

namespace myrialux {
namespace {

constexpr std::size_t kRows = 1024, kColumns = 1000;

/// Receivers on the floor of a box, lights on its other walls; a share of both is glossy.
struct Slice {
  Scene scene;
  std::unique_ptr<Tracer> tracer;
  std::unique_ptr<Emitters> emitters;
  Receivers receivers;
  VirtualLights lights;
  std::vector<ReceiverId> rows;
  std::vector<Column> columns;
  BitMatrix visible{kRows, kColumns};
  std::vector<Rgb> radiance = std::vector<Rgb>(kRows);
};

struct Mix {
  std::uint32_t glossy_rows = 0;    ///< of 16 rows
  std::uint32_t glossy_lights = 0;  ///< of 16 columns
  BsdfKind kind = BsdfKind::rough_plastic;
  bool curved = false;  ///< shading normals differ from geometric ones
};

void add_scene(Slice& slice, BsdfKind kind) {
  Scene& scene = slice.scene;
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  scene.meshes.push_back(mesh);
  Material diffuse, glossy;
  glossy.kind = kind;
  glossy.distribution = Microfacets::ggx;
  scene.materials = {diffuse, glossy};
  Shape shape;
  shape.geometry = MeshId{};
  shape.material = MaterialId{};
  shape.emitter = EmitterId{};
  scene.shapes.push_back(shape);
  scene.placed.push_back(ShapeId{});
  Emitter emitter;
  emitter.kind = AreaEmitter{ShapeId{}, {gray(1)}};
  scene.emitters.push_back(emitter);
  slice.tracer = std::make_unique<Tracer>(scene);
  slice.emitters = std::make_unique<Emitters>(scene, slice.tracer->bounds());
}

std::unique_ptr<Slice> make_slice(const Mix& mix) {
  auto slice = std::make_unique<Slice>();
  add_scene(*slice, mix.kind);
  Rng rng({1}, Stage::test, 0);
  const auto bsdf = [&](bool glossy) {
    return BsdfParams{static_cast<MaterialId>(glossy), 0.2f, gray(0.5f), gray(0.5f)};
  };
  const auto bent = [&](Vec3 n) {
    return mix.curved ? normalize(n + 0.2f * Vec3{rng.next(), rng.next(), rng.next()}) : n;
  };
  for (std::size_t i = 0; i < kRows; ++i) {
    Receivers& r = slice->receivers;
    r.p.push_back({rng.next(), rng.next(), 0});
    r.ng.push_back({0, 0, 1});
    r.n.push_back(bent({0, 0, 1}));
    r.wo.push_back(normalize({rng.next(), rng.next(), 1}));
    r.bsdf.push_back(bsdf(i % 16 < mix.glossy_rows));
    r.inside.push_back(0), r.offset.push_back(0);
    slice->rows.push_back(static_cast<ReceiverId>(i));
  }
  for (std::size_t c = 0; c < kColumns; ++c) {
    VirtualLights& l = slice->lights;
    const bool glossy = c * 16 >= kColumns * (16 - mix.glossy_lights);
    l.p.push_back({rng.next(), rng.next(), 1 + rng.next()});
    l.ng.push_back({0, 0, -1});
    l.n.push_back(bent({0, 0, -1}));
    l.light.push_back({rng.next(), rng.next(), rng.next()});
    l.kind.push_back(glossy ? LightKind::glossy : LightKind::oriented);
    l.extra.push_back(glossy ? static_cast<std::uint32_t>(l.glossy.size()) : 0xffffffffu);
    if (glossy) l.glossy.push_back({normalize({rng.next(), rng.next(), -1}), bsdf(true)});
    l.offset.push_back(0), l.bounce.push_back(0);
    slice->columns.push_back({.light = static_cast<LightId>(c)});
    for (std::size_t i = 0; i < kRows; ++i)
      if (rng.below(2)) slice->visible.set(i, c);
  }
  return slice;
}

void shade(benchmark::State& state, std::int64_t isa, const Mix& mix) {
  force_isa(isa);
  const std::unique_ptr<Slice> slice = make_slice(mix);
  const World world{.scene = slice->scene, .tracer = *slice->tracer, .emitters = *slice->emitters};
  for (auto _ : state) {
    const ShadeResult result = shade_slice(world, slice->receivers, slice->rows, slice->lights, slice->columns,
                                           slice->visible, {.clamp_distance = 0.2f}, slice->radiance);
    benchmark::DoNotOptimize(result);
  }
  state.counters["pairs"] =
      benchmark::Counter(static_cast<double>(kRows * kColumns), benchmark::Counter::kIsIterationInvariantRate);
  force_isa(0);
}

struct Named {
  const char* name;
  Mix mix;
};
const Named kMixes[] = {
    {"diffuse", {}},
    {"diffuse_curved", {.curved = true}},
    {"rough_plastic", {.glossy_rows = 16}},
    {"rough_conductor", {.glossy_rows = 16, .kind = BsdfKind::rough_conductor}},
    {"rough_dielectric", {.glossy_rows = 16, .kind = BsdfKind::rough_dielectric}},
    {"glossy_lights", {.glossy_lights = 16}},
    {"mixed", {.glossy_rows = 4, .glossy_lights = 2, .curved = true}},
};

const bool registered = [] {
  for (const std::int64_t isa : available_isas())
    for (const Named& named : kMixes)
      benchmark::RegisterBenchmark(("shade/" + std::string(named.name) + "/" + isa_name(isa)).c_str(), shade, isa,
                                   named.mix)
          ->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
}  // namespace myrialux
