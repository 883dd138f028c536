// Adds up the arrays that live at the same time in each stage of a frame; the largest sum is what the frame takes.
#include "myrialux/pipeline/memory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/clusters/gather_tree.h"
#include "myrialux/clusters/point_tree.h"
#include "myrialux/clusters/receiver_cut.h"
#include "myrialux/film/film.h"
#include "myrialux/methods/auto_clusters.h"
#include "myrialux/methods/slice_driver.h"
#include "myrialux/pipeline/clamp.h"
#include "myrialux/pipeline/frame_state.h"
#include "myrialux/reference/path_tracer.h"

namespace myrialux {
namespace {

using Bytes = std::uint64_t;
constexpr Bytes kMiB = 1 << 20;

/// Pages of libraries first touched late, TBB's and the allocator's caches, stacks: measured at 6 to 10 MiB and about
/// 1 MiB a thread.
constexpr Bytes kAllowance = 12 * kMiB, kThreadAllowance = 2 * kMiB;

/// What a frame takes, by the names that a message tells.
struct Parts {
  Bytes film = 0, receivers = 0, lights = 0, slices = 0, other = 0;
  Bytes sum() const { return film + receivers + lights + slices + other; }
};

Bytes n_pixels(const FrameExtent& f) { return Bytes(f.width) * Bytes(f.height); }
/// Camera samples held at once.
Bytes n_samples(const FrameExtent& f) { return Bytes(f.width) * Bytes(rows_at_once(f)) * Bytes(f.spp); }

/// Columns of a slice, and the bytes of a bit for each row in them.
Bytes n_columns(const FrameExtent& f) { return std::min<Bytes>(f.n_clusters, f.n_lights); }
Bytes bits_bytes(const FrameExtent& f) { return n_columns(f) * ((Bytes(f.slice_rows) + 63) / 64) * 8; }

/// One slice in flight. Bits: active, required, visible, and at most the same again, known and visible, in the basis of
/// completion, which grows by doubling. A column besides: the cut's heap, columns, shadow and shading lights and lobes.
Bytes slice_bytes(const FrameExtent& f) {
  if (f.has_packets) return n_columns(f) * kPacketCutBytes;
  constexpr Bytes kRow = 200, kColumn = 500, kTable = 256;
  const Bytes matrices = f.has_errors ? 9 : 7;  // the meter's sums are four bytes for each block of 16 rows
  const Bytes glossy = std::min<Bytes>(n_columns(f), f.n_glossy);
  return kRow * f.slice_rows + n_columns(f) * kColumn + matrices * bits_bytes(f) + glossy * kTable +
         n_columns(f) * f.slice_rows * f.completion_bytes;
}

/// The cut of one pixel: pairs and heap, which grow by doubling; nodes of its receivers' tree and what stands beside.
Bytes pixel_cut_bytes(const FrameExtent& f) {
  constexpr Bytes kPair = 3 * (2 * sizeof(std::uint32_t) + sizeof(Rgb) + sizeof(std::uint64_t));
  constexpr Bytes kReceiver = 3 * (2 * (sizeof(GatherNode) + sizeof(Rgb)) + 64);
  const Bytes pairs = std::min<Bytes>(f.n_clusters, Bytes(f.spp) * f.n_lights);
  return pairs * kPair + Bytes(f.spp) * kReceiver;
}

/// One block of an illumination cut in flight, and the lists from the root to it: its pairs, at most so many columns at
/// once. Lists hold no more than a few light nodes a light; far fewer unless the error threshold is next to 0.
Bytes block_bytes(const FrameExtent& f) {
  constexpr Bytes kColumn = 500 + 256 + 64, kColumns = 1024, kListed = 64;
  return kColumns * kColumn + kListed * f.n_lights;
}

/// Of every receiver: two nodes at most, its place in the order; while building also its code.
constexpr Bytes kPointNodes = 2 * sizeof(PointNode), kPointCode = 16;

Bytes pilot_bytes(const FrameExtent& f) {
  const Bytes n_slices = n_samples(f) / f.slice_rows + 1;
  if (!f.has_pilot || n_slices < kLeastSlices) return 0;
  return (n_slices / pilot_stride(n_slices) + 1) * slice_bytes(f);
}

/// The reduced matrix, two bytes an entry, and the clustering of its columns: projected once, and then a copy for each
/// slice in flight, with the eight rows of its neighbourhood.
Bytes reduced_bytes(const FrameExtent& f) {
  constexpr Bytes kEntry = 2, kColumn = 32, kLocalColumn = 80, kTile = 2 * kMiB;
  const Bytes dimensions = std::min(f.reduced_dimensions, f.reduced_rows), threads = Bytes(f.n_threads);
  const Bytes working = std::max(f.n_lights * dimensions * sizeof(float), threads * f.n_lights * kLocalColumn);
  return f.reduced_rows > 0 ? f.n_lights * (f.reduced_rows * kEntry + kColumn) + working + threads * kTile : 0;
}

Parts largest(std::initializer_list<Parts> stages) {
  return std::max(stages, [](const Parts& a, const Parts& b) { return a.sum() < b.sum(); });
}

/// Each stage of a many-light pass; rows and film stay to its end.
Parts pass_parts(const FrameExtent& f) {
  constexpr Bytes kGlossy = sizeof(VirtualLights::Glossy);
  constexpr Bytes kLight = 3 * sizeof(Vec3) + sizeof(float) + sizeof(Rgb) + sizeof(std::uint32_t) + 2;
  constexpr Bytes kTreeLight = sizeof(LightNode) + sizeof(LightId) + sizeof(float), kTreePoint = 40;
  constexpr Bytes kSlicePoint = 28, kOrder = sizeof(ReceiverId);
  const Bytes samples = n_samples(f), lights = f.n_lights * kLight + f.n_glossy * kGlossy;
  const Bytes tree = f.n_lights * kTreeLight + f.n_glossy * 2 * sizeof(GlossyNode);
  // Of every receiver: radiance; with slices also slice, cut size, visibility, its error. A slice's report is 1/8 byte
  // a row.
  const Bytes result = samples * ((f.has_slices ? 24 + 1 : 12 + 1) + (f.has_errors ? 4 : 0));
  Parts base;
  base.film = n_pixels(f) * FrameState::bytes_a_pixel();
  base.receivers = samples * (kReceiverBytes + kSampleBytes);

  Parts receivers = base, reading = base, grouping = base, building = base, gathering = base;
  receivers.receivers += samples * kSampleLayerBytes;
  // Read lights grow by doubling, so one array stands there twice; traced ones wait in blocks.
  reading.lights =
      lights + (f.lights_file_bytes > 0 ? f.lights_file_bytes + f.n_lights * kGlossy : Bytes(f.n_threads) * 4 * kMiB);
  grouping.lights = building.lights = gathering.lights = lights;
  gathering.receivers += result;
  if (f.has_slices) {
    grouping.slices = samples * (kSlicePoint + kOrder);
    building.slices = samples * kOrder, building.lights += tree + f.n_lights * kTreePoint;
    gathering.slices = samples * kOrder + Bytes(f.n_threads) * slice_bytes(f) + pilot_bytes(f) + reduced_bytes(f);
    gathering.lights += tree;
    // The choice is over before slices are in flight; their memory is counted besides, as it may not have been freed.
    if (f.has_auto_clusters) gathering.slices += kAutoBytes;
  }
  if (f.has_pixel_cuts) {
    building.lights += tree + f.n_lights * kTreePoint, gathering.lights += tree;
    gathering.slices = Bytes(f.n_threads) * pixel_cut_bytes(f);
  }
  if (f.has_point_tree) {
    grouping.slices = samples * (kPointCode + kOrder + kPointNodes);
    building.slices = 0;
    gathering.slices = samples * (kOrder + kPointNodes) + Bytes(f.n_threads) * block_bytes(f);
    grouping.lights += tree;
  }
  if (f.band_samples == 0) return largest({receivers, reading, grouping, building, gathering});
  // In bands the lights and their tree stand first; few receivers of each pixel tell the scene's size. Positions grow
  // by doubling, row by row, and are then put together.
  constexpr Bytes kSizePoint = 4 * sizeof(Vec3);
  Parts sizing = base, tracing = gathering;
  if (f.has_slices) grouping.lights += tree;
  sizing.lights = lights, sizing.receivers = n_pixels(f) * std::min<Bytes>(Bytes(f.spp), kSizeSamples) * kSizePoint;
  tracing.receivers = receivers.receivers;
  return largest({reading, sizing, building, tracing, grouping, gathering});
}

Parts path_parts(const FrameExtent& f) {
  Parts parts;
  parts.film = n_pixels(f) * FrameState::bytes_a_pixel();
  parts.receivers = Bytes(path_rows_at_once(f)) * Bytes(f.width) * Bytes(f.spp) * kPathSampleBytes;
  return parts;
}

Parts frame_parts(const FrameExtent& f) {
  const Bytes picture = n_pixels(f) * f.n_channels * sizeof(float);
  Parts developing, writing;
  developing.film = n_pixels(f) * FrameState::bytes_a_pixel() + picture;
  writing.film = picture + picture_write_bytes(f.width, f.height, f.n_channels, f.n_threads);
  Parts parts = largest({f.has_lights ? pass_parts(f) : path_parts(f), developing, writing});
  parts.other = kAllowance + Bytes(f.n_threads) * kThreadAllowance;
  return parts;
}

/// Fewer virtual lights, of the same kinds.
FrameExtent with_lights(FrameExtent f, std::uint64_t n) {
  const double share = static_cast<double>(n) / static_cast<double>(std::max<std::uint64_t>(1, f.n_lights));
  f.n_glossy = static_cast<std::uint64_t>(static_cast<double>(f.n_glossy) * share);
  f.n_lights = n;
  return f;
}

/// Options each of which alone makes the frame fit.
std::vector<std::string> smaller_settings(const FrameExtent& f, Bytes room) {
  std::vector<std::string> options;
  const auto fits = [&](const FrameExtent& smaller) { return frame_bytes(smaller) <= room; };
  FrameExtent g = f;
  while (g.spp > 1 && !fits(g)) --g.spp;
  if (f.has_lights && fits(g))
    options.push_back(fmt::format("--spp {} --passes {}", g.spp, (f.passes * f.spp + g.spp - 1) / g.spp));
  g = f;
  g.has_auto_clusters = false;
  while (g.n_clusters > 100 && !fits(g)) g.n_clusters /= 2;
  if (f.has_cuts && !f.has_point_tree && fits(g)) options.push_back(fmt::format("--clusters {}", g.n_clusters));
  g = f;
  while (g.n_lights > 1000 && !fits(g)) g = with_lights(g, g.n_lights / 2);
  if (f.has_lights && f.lights_file_bytes == 0 && fits(g)) options.push_back(fmt::format("--vpls {}", g.n_lights));
  g = f, g.n_threads = 1;
  if (f.n_threads > 1 && fits(g)) options.push_back("--threads 1");
  for (int k = 31; k > 0; --k) {
    g = f, g.width = std::max(1, f.width * k / 32), g.height = std::max(1, f.height * k / 32);
    if (!fits(g)) continue;
    options.push_back(fmt::format("--size {}x{}", g.width, g.height));
    break;
  }
  return options;
}

Bytes in_mib(Bytes bytes) { return (bytes + kMiB - 1) / kMiB; }

}  // namespace

std::uint64_t frame_bytes(const FrameExtent& frame) { return frame_parts(frame).sum(); }

int rows_at_once(const FrameExtent& f) {
  if (f.band_rows > 0) return std::min(f.band_rows, f.height);
  const Bytes rows = f.band_samples / std::max<Bytes>(1, Bytes(f.width) * Bytes(f.spp));
  return f.band_samples == 0 ? f.height : static_cast<int>(std::clamp<Bytes>(rows, 1, Bytes(f.height)));
}

int path_rows_at_once(const FrameExtent& f) {
  constexpr Bytes kSamples = 1 << 20;
  const Bytes a_row = std::max<Bytes>(1, Bytes(f.width) * Bytes(f.spp));
  const Bytes rows = std::max<Bytes>(kSamples / a_row, 8 * Bytes(f.n_threads));
  return static_cast<int>(std::min<Bytes>(rows, Bytes(f.height)));
}

void require_memory(const FrameExtent& frame, std::uint64_t held, std::uint64_t peak, std::uint64_t limit) {
  const Parts parts = frame_parts(frame);
  const Bytes needed = std::max(peak, held + parts.sum());
  if (needed <= limit) return;
  // A repeated run holds a little more or less: the number told is one that will do, and so are the settings.
  const Bytes enough = in_mib(needed + needed / 100) + 1, surely_held = held + limit / 100 + kMiB;
  std::string message = fmt::format(
      "about {} MiB are needed but --memory-limit allows {} MiB (scene and program {}, receivers {}, virtual "
      "lights {}, slices {}, film {}, allowance {} MiB); ",
      enough, limit / kMiB, in_mib(held), in_mib(parts.receivers), in_mib(parts.lights), in_mib(parts.slices),
      in_mib(parts.film), in_mib(parts.other));
  if (peak >= limit)
    message += fmt::format("reading the scene alone took {} MiB; give it at least that", in_mib(peak));
  else if (const auto options = smaller_settings(frame, limit - std::min(limit, surely_held)); !options.empty())
    message += fmt::format("{} would fit: {}", options.size() > 1 ? "each of these" : "this", fmt::join(options, "; "));
  else
    message +=
        fmt::format("no single option makes it fit: lower --size, --spp and --vpls together, or allow {} MiB", enough);
  throw Error(ErrorKind::limit, message);
}

}  // namespace myrialux
