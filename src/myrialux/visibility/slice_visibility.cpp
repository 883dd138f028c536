// Rows laid out in blocks of 64, columns reduced to what segments need; a block of 16 rows is a packet of rays.
#include "myrialux/visibility/slice_visibility.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/kernels/active_bits.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/trace/embree.h"
#include "myrialux/transfer/transfer.h"
#include "myrialux/visibility/occluder_cache.h"
#include "myrialux/visibility/shadow_light.h"

namespace myrialux {
namespace {

/// A packet's cost hardly depends on how many lanes are on, and 16 far rows cost about two packets of 16 near ones: so
/// blocks with fewer wanted rows than this share packets with others.
constexpr int kLeastOwnRows = 8;

/// Remembered triangles are turned to a light for at least so many packets of adjacent rows: for fewer it does not pay.
constexpr std::size_t kLeastPackets = 8;

/// A packet with so many blocked rays tells a triangle worth remembering; one is asked for in each column.
constexpr int kLeastBlocked = 8;

/// Time in steps of any length, as fast as can be.
std::uint64_t read_ticks() {
#ifdef __x86_64__
  return __builtin_ia32_rdtsc();
#else
  return static_cast<std::uint64_t>(1e9 * read_clock(CLOCK_MONOTONIC));
#endif
}

struct alignas(64) BlockOffsets {
  BlockFloats offset;
};
/// Where segments start on the front side.
struct alignas(64) BlockStarts {
  BlockFloats p[3];
};

/// Wanted rows of sparse blocks, moved together until a packet is full.
struct alignas(64) GatheredRows {
  PacketFloats p[3] = {}, ng[3] = {}, offset = {};  ///< the last two unless ends are fixed; p is the start if so
  std::array<std::uint32_t, kPacketRows> row{};
  std::size_t size = 0;
};

/// Packets on their way: rays of several are made before the first is traced, so that Embree does not wait for what
/// has just been written.
struct alignas(64) Packets {
  static constexpr std::size_t kMost = 8;  ///< 6 KiB stay in the first cache
  PacketRays to(std::size_t k) {
    RTCRay16& r = rays[k];
    return {.origin = {r.org_x, r.org_y, r.org_z},
            .direction = {r.dir_x, r.dir_y, r.dir_z},
            .far = r.tfar,
            .stride = sizeof(RTCRay16) / sizeof(float)};
  }
  RTCRay16 rays[kMost];
  std::uint32_t valid[kMost], blocked[kMost];
  std::uint32_t first_row[kMost];  ///< of adjacent rows; kGathered: see `rows`
  std::array<std::uint32_t, kPacketRows> rows[kMost];
  std::size_t size = 0;
};
constexpr std::uint32_t kGathered = 0xffffffffu;

PacketRows packet_rows(const RowBlock& rows, const BlockOffsets& offsets, std::size_t first) {
  return {{rows.p[0] + first, rows.p[1] + first, rows.p[2] + first},
          {rows.ng[0] + first, rows.ng[1] + first, rows.ng[2] + first},
          offsets.offset + first};
}

PacketRows packet_rows(const GatheredRows& g) {
  return {{g.p[0], g.p[1], g.p[2]}, {g.ng[0], g.ng[1], g.ng[2]}, g.offset};
}

bool is_spot(const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::point && lights.extra[j] != 0xffffffffu;
}

void copy_to(float* to, Vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

ActivityLight activity_light(const World& world, const VirtualLights& lights, std::size_t j) {
  ActivityLight light{};
  light.distant = lights.kind[j] == LightKind::directional;
  copy_to(light.to, light.distant ? -lights.n[j] : lights.p[j]);
  copy_to(light.n, lights.n[j]);
  copy_to(light.ng, lights.ng[j]);
  if (lights.kind[j] == LightKind::oriented) light.sides = LitSides::front;
  if (lights.kind[j] == LightKind::glossy)
    light.sides = transmits(world, lights.glossy[lights.extra[j]].bsdf) ? LitSides::front_and_back : LitSides::front;
  return light;
}

}  // namespace

struct SliceVisibility::State {
  const Tracer& tracer;
  std::size_t n_rows;
  std::vector<RowBlock> blocks;       ///< [words_per_column]; rows that do not exist have zero normals
  std::vector<BlockOffsets> offsets;  ///< [words_per_column]
  std::vector<ShadowLight> lights;    ///< [n_columns]
  /// Active rows of one-sided surfaces lie in front of a light's one side and it in front of theirs: then both ends
  /// are known before they are joined. [words_per_column]; empty if some row is two-sided or not only active entries
  /// are traced
  std::vector<BlockStarts> starts;
  std::vector<std::optional<KnownEnd>> ends;  ///< [n_columns], or empty like `starts`
  std::vector<std::size_t> group_ends;
  BitMatrix active, required;
  std::vector<RowPoint> points;  ///< [n_rows]
  std::vector<float> energies;   ///< [n_columns], or empty
  std::optional<BlockEnergies> block_energies;
  Packets on_the_way;
  std::optional<OccluderCache> occluders;  ///< where ends are known; empty: nothing is remembered
  std::size_t aimed_at = ~std::size_t{0};  ///< column
  bool is_searching = false;               ///< for a triangle to remember
  bool is_remembering = false;             ///< in the call at hand
  std::uint64_t rays = 0, packets = 0;
  std::uint64_t ticks_in_trace = 0, first_tick = read_ticks();
  Stopwatch wall;
  ThreadStopwatch cpu;

  void lay_out_rows(const Receivers& receivers, std::span<const ReceiverId> rows);
  void group_columns(Vec3 centre, const VirtualLights& all, std::span<const Column> columns);
  void find_active(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                   const VirtualLights& all, std::span<const Column> columns);
  void fix_ends(const VirtualLights& all, std::span<const Column> columns, std::span<const ActivityLight> activity);
  /// Sends packets off; their bits arrive at the latest with land(). First those of a block of 64 rows that have
  /// enough of them; returns the rows left over.
  std::uint64_t send_block(std::size_t j, std::size_t word, std::uint64_t wanted, MutableWords visible);
  void announce(std::uint32_t valid, std::uint32_t first_row);
  void land(MutableWords visible);
  void gather(GatheredRows& gathered, std::size_t j, std::size_t word, std::uint64_t rows, MutableWords visible);
  void send_gathered(GatheredRows& gathered, std::size_t j, MutableWords visible);
  void aim(std::size_t j, Words wanted);
  std::uint64_t shadowed_blocks(std::size_t word, std::uint64_t wanted);
  void leave_out_shadowed(GatheredRows& gathered, MutableWords visible);
  void remember_occluder();
  bool is_shadowed() const { return is_remembering && !occluders->is_clear(); }
  bool is_fixed(std::size_t j) const { return !ends.empty() && ends[j].has_value(); }
};

SliceVisibility::SliceVisibility(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                                 const VirtualLights& lights, std::span<const Column> columns, bool cull)
    : state_(new State{.tracer = world.tracer,
                       .n_rows = rows.size(),
                       .blocks = {},
                       .offsets = {},
                       .lights = {},
                       .starts = {},
                       .ends = {},
                       .group_ends = {},
                       .active = BitMatrix(rows.size(), columns.size()),
                       .required = {},
                       .points = {},
                       .energies = {},
                       .block_energies = {},
                       .on_the_way = {},
                       .occluders = {},
                       .wall = {},
                       .cpu = {}}) {
  State& s = *state_;
  for (RTCRay16& rays : s.on_the_way.rays) init_rays(rays);
  s.lay_out_rows(receivers, rows);
  s.group_columns(slice_centre(receivers, rows), lights, columns);
  s.lights.reserve(columns.size());
  for (const Column& column : columns) s.lights.push_back(shadow_light(lights, index(column.light)));
  if (cull)
    s.find_active(world, receivers, rows, lights, columns);
  else
    for (std::size_t j = 0; j < columns.size(); ++j) fill_rows(s.active.column(j), rows.size());
}

SliceVisibility::~SliceVisibility() = default;

void SliceVisibility::State::lay_out_rows(const Receivers& receivers, std::span<const ReceiverId> rows) {
  blocks.resize(words_for(rows.size()));
  offsets.resize(blocks.size());
  points.reserve(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t i = index(rows[r]);
    RowBlock& block = blocks[r / kBlockRows];
    for (int k = 0; k < 3; ++k) {
      block.p[k][r % kBlockRows] = receivers.p[i][k];
      block.n[k][r % kBlockRows] = receivers.n[i][k];
      block.ng[k][r % kBlockRows] = receivers.ng[i][k];
    }
    offsets[r / kBlockRows].offset[r % kBlockRows] = receivers.offset[i];
    points.push_back({receivers.p[i].x, receivers.p[i].y, receivers.p[i].z});
  }
}

/// Columns come ordered by kind and octant: each run of equal kind and octant is a group.
void SliceVisibility::State::group_columns(Vec3 centre, const VirtualLights& all, std::span<const Column> columns) {
  std::uint32_t previous = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const std::uint32_t kind = static_cast<std::uint32_t>(all.kind[index(columns[j].light)]);
    const std::uint32_t group = kind * 8 + octant(centre, all, columns[j].light);
    if (j > 0 && group != previous) group_ends.push_back(j);
    previous = group;
  }
  if (!columns.empty()) group_ends.push_back(columns.size());
}

void SliceVisibility::State::find_active(const World& world, const Receivers& receivers,
                                         std::span<const ReceiverId> rows, const VirtualLights& all,
                                         std::span<const Column> columns) {
  if (columns.empty()) return;
  std::vector<std::uint64_t> both_sides(blocks.size());
  bool one_sided = true;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (transmits(world, receivers.bsdf[index(rows[r])])) set_bit(both_sides, r), one_sided = false;
  std::vector<ActivityLight> activity;
  activity.reserve(columns.size());
  for (const Column& column : columns) activity.push_back(activity_light(world, all, index(column.light)));
  active_bits(blocks, both_sides, activity, MutableWords(active.column(0).data(), active.n_words()));
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const LightId light = columns[j].light;
    if (is_spot(all, index(light)))  // few, and their cone is a matter of angles
      for_each_bit(active.column(j), [&](std::size_t r) {
        if (!is_active(world, receivers, rows[r], all, light)) clear_bit(active.column(j), r);
      });
  }
  if (one_sided) fix_ends(all, columns, activity);
}

/// The operations of shadow_rays() where the signs of both cosines are known, so that bits are the same.
void SliceVisibility::State::fix_ends(const VirtualLights& all, std::span<const Column> columns,
                                      std::span<const ActivityLight> activity) {
  starts.resize(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int k = 0; k < 3; ++k)
      for (std::size_t row = 0; row < kBlockRows; ++row)
        starts[b].p[k][row] = blocks[b].p[k][row] + blocks[b].ng[k][row] * offsets[b].offset[row];
  Box3 box;
  for (std::size_t r = 0; r < n_rows; ++r) {
    const BlockStarts& start = starts[r / kBlockRows];
    box.add(Vec3{start.p[0][r % kBlockRows], start.p[1][r % kBlockRows], start.p[2][r % kBlockRows]});
  }
  occluders.emplace(box);
  ends.resize(columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const ShadowLight light = shadow_light(all, index(columns[j].light));
    if (light.end == SegmentEnd::surface && activity[j].sides != LitSides::front) continue;
    KnownEnd end{{light.p[0], light.p[1], light.p[2]}, light.end == SegmentEnd::direction};
    if (light.end == SegmentEnd::surface)
      for (int k = 0; k < 3; ++k) end.p[k] += light.ng[k] * light.offset;
    ends[j] = end;
  }
}

std::size_t SliceVisibility::n_rows() const { return state_->n_rows; }
std::size_t SliceVisibility::n_columns() const { return state_->lights.size(); }
Words SliceVisibility::active(std::size_t j) const { return std::as_const(state_->active).column(j); }
Words SliceVisibility::required(std::size_t j) const {
  return state_->required.n_columns() > 0 ? std::as_const(state_->required).column(j) : Words{};
}
float SliceVisibility::energy(std::size_t j) const { return state_->energies.empty() ? 1.0f : state_->energies[j]; }
std::span<const RowPoint> SliceVisibility::row_points() const { return state_->points; }
std::size_t SliceVisibility::n_groups() const { return state_->group_ends.size(); }
std::size_t SliceVisibility::group_end(std::size_t g) const { return state_->group_ends[g]; }
const BitMatrix& SliceVisibility::active_matrix() const { return state_->active; }
void SliceVisibility::forget_occluders() { state_->occluders.reset(); }
void SliceVisibility::require(BitMatrix required) {
  MYRIALUX_ASSERT(required.n_rows() == n_rows() && required.n_columns() == n_columns());
  state_->required = std::move(required);
}
void SliceVisibility::set_energies(std::vector<float> energies) {
  MYRIALUX_ASSERT(energies.size() == n_columns());
  state_->energies = std::move(energies);
}
void SliceVisibility::block_energies(std::size_t j, std::span<float> energies) const {
  if (state_->block_energies)
    state_->block_energies->of(j, energies);
  else
    EntrySource::block_energies(j, energies);
}
void SliceVisibility::set_block_energies(BlockEnergies energies) {
  state_->block_energies.emplace(std::move(energies));
}
const BlockEnergies* SliceVisibility::known_block_energies() const {
  return state_->block_energies ? &*state_->block_energies : nullptr;
}
std::uint64_t SliceVisibility::rays() const { return state_->rays; }
std::uint64_t SliceVisibility::packets() const { return state_->packets; }

/// The counter of ticks costs a fiftieth of the thread's clock to read; what the thread had of the time since the slice
/// began turns one into the other.
double SliceVisibility::trace_seconds() const {
  const std::uint64_t ticks = read_ticks() - state_->first_tick;
  const double share = ticks > 0 ? static_cast<double>(state_->ticks_in_trace) / static_cast<double>(ticks) : 0;
  return share * std::min(state_->wall.elapsed(), state_->cpu.elapsed());
}

std::size_t SliceVisibility::memory_bytes() const {
  const State& s = *state_;
  return s.blocks.size() * (sizeof(RowBlock) + sizeof(BlockOffsets)) + s.lights.size() * sizeof(ShadowLight) +
         s.starts.size() * sizeof(BlockStarts) + s.ends.size() * sizeof(std::optional<KnownEnd>) +
         (s.block_energies ? s.block_energies->memory_bytes() : 0) + s.points.size() * sizeof(RowPoint) +
         s.energies.size() * sizeof(float) + (s.active.n_words() + s.required.n_words()) * sizeof(std::uint64_t);
}

void SliceVisibility::trace(std::size_t j, Words wanted, MutableWords visible) {
  State& s = *state_;
  const std::uint64_t start = read_ticks();
  GatheredRows gathered;
  s.aim(j, wanted);
  for (std::size_t w = 0; w < wanted.size(); ++w) {
    MYRIALUX_ASSERT((wanted[w] & ~active(j)[w]) == 0);
    if (wanted[w] == 0) continue;
    s.rays += static_cast<std::uint64_t>(std::popcount(wanted[w]));
    const std::uint64_t shadowed = s.is_shadowed() ? s.shadowed_blocks(w, wanted[w]) : 0;
    visible[w] &= ~shadowed;
    if (wanted[w] == shadowed) continue;
    const std::uint64_t sparse = s.send_block(j, w, wanted[w] & ~shadowed, visible);
    if (sparse != 0) s.gather(gathered, j, w, sparse, visible);
  }
  if (gathered.size > 0) s.leave_out_shadowed(gathered, visible);
  if (gathered.size > 0) s.send_gathered(gathered, j, visible);
  s.land(visible);
  s.ticks_in_trace += read_ticks() - start;
}

/// Turns what is remembered to the column's light, where many rows are wanted.
void SliceVisibility::State::aim(std::size_t j, Words wanted) {
  is_remembering = false;
  if (!occluders || !is_fixed(j)) return;
  if (count_bits(wanted) < kLeastPackets * kPacketRows) return;
  is_remembering = true;
  if (aimed_at == j) return;
  occluders->aim(*ends[j]);
  aimed_at = j, is_searching = true;
}

/// Rows of blocks with packets of their own that are known to be blocked.
std::uint64_t SliceVisibility::State::shadowed_blocks(std::size_t word, std::uint64_t wanted) {
  std::uint64_t own = 0;
  for (std::uint32_t q = 0; q < kBlockRows; q += kPacketRows) {
    const std::uint64_t part = wanted & std::uint64_t{0xffff} << q;
    if (std::popcount(part) >= kLeastOwnRows) own |= part;
  }
  if (own == 0) return 0;
  const float* const start[3] = {starts[word].p[0], starts[word].p[1], starts[word].p[2]};
  return occluders->blocked(start, own);
}

void SliceVisibility::State::announce(std::uint32_t valid, std::uint32_t first_row) {
  Packets& p = on_the_way;
  p.valid[p.size] = valid, p.first_row[p.size] = first_row;
  ++p.size, ++packets;
}

std::uint64_t SliceVisibility::State::send_block(std::size_t j, std::size_t word, std::uint64_t wanted,
                                                 MutableWords visible) {
  Packets& p = on_the_way;
  constexpr std::uint32_t kParts = kBlockRows / kPacketRows;
  if (p.size + kParts > Packets::kMost) land(visible);
  const std::size_t first = p.size;
  std::uint64_t sparse = 0;
  std::uint32_t which = 0;
  for (std::uint32_t q = 0; q < kParts; ++q) {
    const std::uint64_t part = wanted & std::uint64_t{0xffff} << kPacketRows * q;
    if (std::popcount(part) < kLeastOwnRows) {
      sparse |= part;
      continue;
    }
    which |= 1u << q;
    announce(static_cast<std::uint32_t>(part >> kPacketRows * q),
             static_cast<std::uint32_t>(word * kBlockRows + kPacketRows * q));
  }
  if (is_fixed(j)) {
    const float* const start[3] = {starts[word].p[0], starts[word].p[1], starts[word].p[2]};
    shadow_rays_to(start, which, *ends[j], kSegmentEnd, p.to(first));
    return sparse;
  }
  for (std::size_t k = first; which != 0; which &= which - 1, ++k)
    shadow_rays(
        packet_rows(blocks[word], offsets[word], kPacketRows * static_cast<std::size_t>(std::countr_zero(which))),
        lights[j], kSegmentEnd, p.to(k));
  return sparse;
}

void SliceVisibility::State::land(MutableWords visible) {
  Packets& p = on_the_way;
  tracer.occluded_rays(std::span(p.rays, p.size), std::span(p.valid, p.size), std::span(p.blocked, p.size));
  if (is_remembering && is_searching) remember_occluder();
  for (std::size_t k = 0; k < p.size; ++k) {
    const std::uint32_t seen = p.valid[k] & ~p.blocked[k];
    if (p.first_row[k] != kGathered) {
      const std::size_t w = p.first_row[k] / kBlockRows, shift = p.first_row[k] % kBlockRows;
      visible[w] = (visible[w] & ~(std::uint64_t{p.valid[k]} << shift)) | std::uint64_t{seen} << shift;
      continue;
    }
    const auto n = static_cast<std::size_t>(std::popcount(p.valid[k]));
    for (std::size_t lane = 0; lane < n; ++lane) {
      if (seen >> lane & 1)
        set_bit(visible, p.rows[k][lane]);
      else
        clear_bit(visible, p.rows[k][lane]);
    }
  }
  p.size = 0;
}

void SliceVisibility::State::gather(GatheredRows& gathered, std::size_t j, std::size_t word, std::uint64_t rows,
                                    MutableWords visible) {
  const RowBlock& block = blocks[word];
  const bool fixed = is_fixed(j);
  for (; rows != 0; rows &= rows - 1) {
    const std::size_t bit = static_cast<std::size_t>(std::countr_zero(rows)), lane = gathered.size++;
    for (int k = 0; k < 3; ++k) {
      gathered.p[k][lane] = fixed ? starts[word].p[k][bit] : block.p[k][bit];
      if (!fixed) gathered.ng[k][lane] = block.ng[k][bit];
    }
    if (!fixed) gathered.offset[lane] = offsets[word].offset[bit];
    gathered.row[lane] = static_cast<std::uint32_t>(word * kBlockRows + bit);
    if (gathered.size < kPacketRows) continue;
    leave_out_shadowed(gathered, visible);
    if (gathered.size == kPacketRows) send_gathered(gathered, j, visible);
  }
}

/// Rows known to be blocked make room for others.
void SliceVisibility::State::leave_out_shadowed(GatheredRows& g, MutableWords visible) {
  if (!is_shadowed()) return;
  const float* const start[3] = {g.p[0], g.p[1], g.p[2]};
  const std::uint64_t blocked = occluders->blocked(start, low_bits(g.size));
  if (blocked == 0) return;
  std::size_t n = 0;
  for (std::size_t lane = 0; lane < g.size; ++lane) {
    if (blocked >> lane & 1) {
      clear_bit(visible, g.row[lane]);
      continue;
    }
    for (int k = 0; k < 3; ++k) g.p[k][n] = g.p[k][lane];
    g.row[n++] = g.row[lane];
  }
  g.size = n;
}

/// Of the first packet with enough blocked rays: what blocks the middle one, seen from the light, where shadows are
/// largest.
void SliceVisibility::State::remember_occluder() {
  const Packets& p = on_the_way;
  for (std::size_t k = 0; k < p.size; ++k) {
    const int n = std::popcount(p.blocked[k]);
    if (n < kLeastBlocked) continue;
    std::uint32_t lanes = p.blocked[k];
    for (int before = 0; before < n / 2; ++before) lanes &= lanes - 1;
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const RTCRay16& packet = p.rays[k];
    const Vec3 origin{packet.org_x[lane], packet.org_y[lane], packet.org_z[lane]},
        direction{packet.dir_x[lane], packet.dir_y[lane], packet.dir_z[lane]};
    const auto corners =
        tracer.solid_triangle(ends[aimed_at]->distant ? Ray{.origin = origin, .direction = direction}
                                                      : Ray{origin + direction, -direction, kSegmentEnd});
    if (corners) occluders->add(*corners);
    is_searching = false;
    return;
  }
}

void SliceVisibility::State::send_gathered(GatheredRows& gathered, std::size_t j, MutableWords visible) {
  Packets& p = on_the_way;
  if (p.size == Packets::kMost) land(visible);
  const float* const start[3] = {gathered.p[0], gathered.p[1], gathered.p[2]};
  if (is_fixed(j))
    shadow_rays_to(start, 1, *ends[j], kSegmentEnd, p.to(p.size));
  else
    shadow_rays(packet_rows(gathered), lights[j], kSegmentEnd, p.to(p.size));
  p.rows[p.size] = gathered.row;
  announce(static_cast<std::uint32_t>(low_bits(gathered.size)), kGathered);
  gathered.size = 0;
}

}  // namespace myrialux
