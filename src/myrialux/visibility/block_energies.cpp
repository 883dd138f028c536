// Blocks as balls and cones around their rows; what rows do at most, by the bounds of the light cut.
#include "myrialux/visibility/block_energies.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/lobe_bounds.h"
#include "myrialux/kernels/shadow_ends.h"

namespace myrialux {
namespace {

/// Axis and angle of the narrowest cone around the mean of unit vectors, set in a lane.
void set_cone(std::span<const Vec3> directions, ConeLanes& cone, std::size_t lane) {
  Vec3 sum{};
  for (const Vec3 d : directions) sum = sum + d;
  const float length = std::sqrt(dot(sum, sum));
  const Vec3 axis = length > 0 ? sum * (1 / length) : Vec3{0, 0, 1};
  float least = length > 0 ? 1.0f : -1.0f;
  for (const Vec3 d : directions) least = std::min(least, dot(axis, d));
  for (int a = 0; a < 3; ++a) cone.axis[a][lane] = axis[a];
  cone.cos[lane] = least, cone.sin[lane] = std::sqrt(std::max(0.0f, 1 - least * least));
}

/// A block of rows: ball, cones, and the largest of what each row's lobes can do.
void set_block(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows, float unit,
               BlockCones::Group& g, std::size_t lane) {
  Vec3 normals[kPacketRows], mirrors[kPacketRows], middle{};
  float alpha = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t i = index(rows[k]);
    const BsdfParams& params = receivers.bsdf[i];
    const Bsdf bsdf = make_bsdf(world.scene.materials[index(params.material)], params, world.sharp_alpha);
    const Vec3 n = receivers.n[i], wo = receivers.wo[i];
    const LobeBounds bounds = lobe_bounds(bsdf, Frame(receivers.inside[i] ? -n : n).to_local(wo));
    const float beta = luminance(receivers.beta[i]) / unit;
    normals[k] = n, mirrors[k] = normalize(n * (2 * dot(n, wo)) - wo);
    middle = middle + receivers.p[i] * (1 / static_cast<float>(rows.size()));
    g.diffuse[lane] = std::max(g.diffuse[lane], beta * max_component(bounds.diffuse));
    g.gloss[lane] = std::max(g.gloss[lane], beta * max_component(bounds.gloss));
    g.any[lane] = std::max(g.any[lane], beta * max_component(bounds.any));
    alpha = std::max(alpha, bounds.alpha);
  }
  for (const ReceiverId i : rows) g.radius[lane] = std::max(g.radius[lane], length(receivers.p[index(i)] - middle));
  for (int a = 0; a < 3; ++a) g.p[a][lane] = middle[a];
  g.inverse_alpha2[lane] = alpha < kLargestShapedAlpha ? 1 / (alpha * alpha) : 0.0f;
  set_cone(std::span(normals, rows.size()), g.normal, lane);
  set_cone(std::span(mirrors, rows.size()), g.mirror, lane);
}

/// Ball and cones of each block.
BlockCones block_cones(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       float clamp_distance, float unit) {
  BlockCones blocks;
  blocks.least_distance_squared = std::max(clamp_distance * clamp_distance, 1e-20f);
  const std::size_t n_blocks = (rows.size() + kPacketRows - 1) / kPacketRows;
  blocks.groups.resize((n_blocks + kCutLanes - 1) / kCutLanes);
  for (std::size_t b = 0; b < n_blocks; ++b) {
    BlockCones::Group& g = blocks.groups[b / kCutLanes];
    const std::size_t lane = b % kCutLanes, first = b * kPacketRows;
    set_block(world, receivers, rows.subspan(first, std::min(kPacketRows, rows.size() - first)), unit, g, lane);
    blocks.any_gloss |= g.gloss[lane] > 0 || g.any[lane] > 0;
  }
  return blocks;
}

}  // namespace

BlockEnergies::BlockEnergies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                             const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                             float clamp_distance, float unit)
    : n_columns_(columns.size()),
      n_blocks_((rows.size() + kPacketRows - 1) / kPacketRows),
      bounds_(n_columns_ * n_blocks_) {
  MYRIALUX_ASSERT(unit > 0);
  const BlockCones blocks = block_cones(world, receivers, rows, clamp_distance, unit);
  std::vector<float> bounds(blocks.groups.size() * kCutLanes);
  for (std::size_t j = 0; j < n_columns_; ++j) {
    const LightId light = columns[j].light;
    bound_blocks(blocks, make_light_cluster(world, lights, light, tree.importance[index(light)], columns[j].weight),
                 bounds);
    for (std::size_t b = 0; b < n_blocks_; ++b) bounds_[j * n_blocks_ + b] = short_above(bounds[b]);
  }
}

void BlockEnergies::of(std::size_t j, std::span<float> energies) const {
  MYRIALUX_ASSERT(energies.size() >= n_blocks_);
  for (std::size_t b = 0; b < n_blocks_; ++b) energies[b] = of(j, b);
  std::fill(energies.begin() + static_cast<std::ptrdiff_t>(n_blocks_), energies.end(), 0.0f);
}

}  // namespace myrialux
