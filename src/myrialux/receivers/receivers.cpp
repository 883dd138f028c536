// Rows of the light matrix: camera samples, followed through sharp lobes to where the wide lobes are chosen.
#include "myrialux/receivers/receivers.h"

#include <algorithm>
#include <optional>
#include <type_traits>

#include "myrialux/base/parallel.h"
#include "myrialux/transport/walk.h"

namespace myrialux {
namespace {

/// One camera path followed to its receiver, if it reaches one.
struct Reached {
  Vertex vertex;
  Rgb beta;
  int depth = 0;
};
struct BlockOfSamples {
  std::size_t n_receivers = 0;
  PathCounters rays;
  std::uint64_t inside_walls = 0;
};
constexpr std::size_t kBlockSamples = 1024;  ///< of a work item, about

/// @param sample of the whole picture; @param k its place in `samples`
std::optional<Reached> trace_sample(const World& world, const ReceiverParams& params, std::size_t sample, std::size_t k,
                                    CameraSamples& samples, BlockOfSamples& block);
/// @param lens where the path begins; `ray` may begin further on
std::optional<Reached> follow_sharp(const World& world, Vec3 lens, Ray ray, Rng& rng, std::size_t sample,
                                    CameraSamples& samples, BlockOfSamples& block);
void put(Receivers& to, std::size_t i, const Reached& reached, std::size_t sample);
void record_first_hit(Vec3 lens, CameraSamples& samples, std::size_t sample, const Vertex& vertex);
/// Moves the receivers of all blocks together; block b's begin at b * block_samples.
void close_gaps(Receivers& receivers, const std::vector<BlockOfSamples>& blocks, std::size_t block_samples);

}  // namespace

ReceiverResult trace_receivers(const World& world, const ReceiverParams& params, Progress& progress) {
  const auto n_pixels = static_cast<std::uint64_t>(params.width) * static_cast<std::uint64_t>(params.height);
  progress.stage("receivers", n_pixels * static_cast<std::uint64_t>(params.spp), "samples");
  return trace_receiver_rows(world, params, 0, params.height, progress);
}

ReceiverResult trace_receiver_rows(const World& world, const ReceiverParams& params, int y_begin, int y_end,
                                   Progress& progress) {
  ReceiverResult result;
  CameraSamples& samples = result.samples;
  samples.width = params.width, samples.height = params.height, samples.spp = params.spp, samples.first_row = y_begin;
  const auto width = static_cast<std::size_t>(params.width), spp = static_cast<std::size_t>(params.spp);
  const std::size_t n_pixels = width * static_cast<std::size_t>(y_end - y_begin), n = n_pixels * spp;
  if (n > 0xffffffffu)
    throw Error(ErrorKind::limit, "a pass of " + std::to_string(n) +
                                      " camera samples is more than 2^32 - 1; render more passes of fewer samples");
  samples.position.resize(n), samples.emission.resize(n), samples.albedo.resize(n), samples.normal.resize(n);
  samples.depth.resize(n);
  const std::size_t first = result.receivers.first_sample = width * static_cast<std::size_t>(y_begin) * spp;

  // A block of pixels is a work item with room for a receiver a sample; then the blocks are moved together in order, so
  // that threads do not show.
  const std::size_t block_samples = std::max<std::size_t>(1, kBlockSamples / spp) * spp;
  std::vector<BlockOfSamples> blocks((n + block_samples - 1) / block_samples);
  result.receivers.resize(n);
  parallel_for(blocks.size(), [&](std::size_t b) {
    const std::size_t begin = b * block_samples, end = std::min(n, begin + block_samples);
    for (std::size_t sample = begin; sample < end; ++sample)
      if (const auto reached = trace_sample(world, params, first + sample, sample, samples, blocks[b]))
        put(result.receivers, begin + blocks[b].n_receivers++, *reached, sample);
    progress.advance(end - begin);
  });
  for (const BlockOfSamples& block : blocks) {
    result.camera_rays += block.rays.closest, result.shadow_rays += block.rays.occlusion;
    result.inside_walls += block.inside_walls;
  }
  close_gaps(result.receivers, blocks, block_samples);
  return result;
}

std::vector<Vec3> trace_receiver_positions(const World& world, const ReceiverParams& params, int n_samples,
                                           PathCounters& rays) {
  struct Row {
    std::vector<Vec3> p;
    BlockOfSamples counters;
  };
  std::vector<Row> rows(static_cast<std::size_t>(params.height));
  const auto width = static_cast<std::size_t>(params.width), spp = static_cast<std::size_t>(params.spp);
  parallel_for(rows.size(), [&](std::size_t y) {
    CameraSamples unused;  // of one sample after the other
    unused.position.resize(1), unused.emission.resize(1), unused.albedo.resize(1), unused.normal.resize(1);
    unused.depth.resize(1);
    for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel)
      for (std::size_t k = 0; k < std::min(spp, static_cast<std::size_t>(n_samples)); ++k)
        if (const auto reached = trace_sample(world, params, pixel * spp + k, 0, unused, rows[y].counters))
          rows[y].p.push_back(reached->vertex.surface.p);
  });
  std::vector<Vec3> p;
  for (const Row& row : rows) {
    p.insert(p.end(), row.p.begin(), row.p.end());
    rays += row.counters.rays;
  }
  return p;
}

Vertex receiver_vertex(const World& world, const Receivers& receivers, std::size_t i) {
  Vertex vertex;
  vertex.params = receivers.bsdf[i];
  vertex.bsdf = make_bsdf(world.scene.materials[index(vertex.params.material)], vertex.params, world.sharp_alpha);
  vertex.wo = receivers.wo[i];
  vertex.n = receivers.inside[i] ? -receivers.n[i] : receivers.n[i];
  vertex.surface.p = receivers.p[i];
  vertex.surface.ng = receivers.ng[i];
  vertex.surface.n = receivers.n[i];
  vertex.surface.offset = receivers.offset[i];
  vertex.surface.material = vertex.params.material;
  return vertex;
}

namespace {

/// f(array) for each array of the receivers.
template <class F>
void for_each_array(Receivers& r, const F& f) {
  f(r.p), f(r.offset), f(r.ng), f(r.n), f(r.wo), f(r.bsdf), f(r.beta), f(r.sample), f(r.depth), f(r.inside);
}

}  // namespace

void Receivers::reserve(std::size_t count) {
  for_each_array(*this, [&](auto& array) { array.reserve(count); });
}
void Receivers::resize(std::size_t count) {
  for_each_array(*this, [&](auto& array) { array.resize(count); });
}

namespace {

std::optional<Reached> trace_sample(const World& world, const ReceiverParams& params, std::size_t sample, std::size_t k,
                                    CameraSamples& samples, BlockOfSamples& block) {
  const Camera& camera = world.scene.camera;
  const auto spp = static_cast<std::size_t>(params.spp);
  const CameraSample drawn =
      camera_sample(camera, params.width, sample / spp, static_cast<int>(sample % spp), params.spp, params.key);
  samples.position[k] = drawn.film;
  samples.emission[k] = samples.albedo[k] = {};
  samples.normal[k] = {}, samples.depth[k] = kInfinity;
  const Ray ray = camera_ray(camera, params.width, params.height, drawn);
  Rng rng(params.key, Stage::receiver, sample);
  return follow_sharp(world, lens_point(camera, drawn), ray, rng, k, samples, block);
}

std::optional<Reached> follow_sharp(const World& world, Vec3 lens, Ray ray, Rng& rng, std::size_t sample,
                                    CameraSamples& samples, BlockOfSamples& block) {
  CameraWalk walk;
  while (within_depth(world, walk.depth + 1)) {
    const auto hit = next_surface(world, ray, walk.depth, block.rays, [&](const SurfacePoint* met) {
      samples.emission[sample] += walk.beta * met_emission(world, walk, met, ray);
    });
    if (!hit) break;
    const Vertex vertex = make_vertex(world, *hit, -ray.direction);
    const bool black_back = is_black_back(vertex);
    if (walk.depth++ == 0) {
      record_first_hit(lens, samples, sample, vertex);
      block.inside_walls += black_back;
    }
    if (black_back || !within_depth(world, walk.depth + 1)) break;

    // One of the two kinds of lobes goes on; the receiver's later light is divided by its probability.
    const float sharp = sharp_probability(vertex.bsdf, vertex.to_local(vertex.wo));
    if (!(rng.next() < sharp)) {
      if (!has_lobes(vertex.bsdf, Lobes::wide)) break;
      return Reached{vertex, walk.beta * (1 / (1 - sharp)), walk.depth};
    }
    walk.beta *= 1 / sharp;
    samples.emission[sample] += walk.beta * next_event(world, vertex, Lobes::sharp, /*mis=*/true, rng, block.rays);
    if (!scatter(world, vertex, Lobes::sharp, walk, ray, rng)) break;
  }
  return std::nullopt;
}

void put(Receivers& to, std::size_t i, const Reached& reached, std::size_t sample) {
  const Vertex& v = reached.vertex;
  const bool inside = dot(v.n, v.wo) < 0;
  const Vec3 n = inside ? -v.n : v.n;
  to.p[i] = v.surface.p;
  to.offset[i] = v.surface.offset;
  to.ng[i] = dot(v.surface.ng, n) < 0 ? -v.surface.ng : v.surface.ng;
  to.n[i] = n;
  to.wo[i] = v.wo;
  to.bsdf[i] = v.params;
  to.beta[i] = reached.beta;
  to.sample[i] = static_cast<std::uint32_t>(sample);
  to.depth[i] = static_cast<std::uint8_t>(std::min(reached.depth, 255));
  to.inside[i] = inside;
}

void record_first_hit(Vec3 lens, CameraSamples& samples, std::size_t sample, const Vertex& vertex) {
  samples.albedo[sample] = albedo(vertex.bsdf);
  samples.normal[sample] = vertex.n;
  samples.depth[sample] = length(vertex.surface.p - lens);
}

/// What lies between the first gap and the end moves by way of a buffer, some blocks at a time: their copies do not
/// overlap, so all threads copy.
void close_gaps(Receivers& receivers, const std::vector<BlockOfSamples>& blocks, std::size_t block_samples) {
  constexpr std::size_t kBlocksAtOnce = 256;
  std::vector<std::size_t> to(blocks.size() + 1);
  for (std::size_t b = 0; b < blocks.size(); ++b) to[b + 1] = to[b] + blocks[b].n_receivers;
  std::size_t first_moved = 0;
  while (first_moved < blocks.size() && to[first_moved] == first_moved * block_samples) ++first_moved;
  for_each_array(receivers, [&](auto& array) {
    std::remove_reference_t<decltype(array)> buffer;
    for (std::size_t first = first_moved; first < blocks.size(); first += kBlocksAtOnce) {
      const std::size_t n = std::min(kBlocksAtOnce, blocks.size() - first), begin = to[first];
      buffer.resize(to[first + n] - begin);
      const auto copy_blocks = [&](const auto& from, const auto& into) {
        parallel_for(n, [&](std::size_t k) {
          const std::size_t b = first + k;
          std::copy_n(from(b), blocks[b].n_receivers, into(b));
        });
      };
      const auto in_array = [&](std::size_t b) { return array.data() + b * block_samples; };
      const auto in_buffer = [&](std::size_t b) { return buffer.data() + (to[b] - begin); };
      const auto moved = [&](std::size_t b) { return array.data() + to[b]; };
      copy_blocks(in_array, in_buffer);
      copy_blocks(in_buffer, moved);
    }
    array.resize(to.back());
  });
}

}  // namespace
}  // namespace myrialux
