// Bounds of a light over blocks: equal to the plain twin on every instruction set, and never below a single receiver's.
#include "myrialux/kernels/block_bounds.h"

#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/math/warp.h"

namespace myrialux {
namespace {

void set_random_cone(ConeLanes& cone, std::size_t lane, Rng& rng) {
  const Vec3 axis = sample_sphere({rng.next(), rng.next()});
  for (int a = 0; a < 3; ++a) cone.axis[a][lane] = axis[a];
  cone.cos[lane] = lane % 3 == 0 ? 1.0f : 2 * rng.next() - 1;
  cone.sin[lane] = std::sqrt(1 - cone.cos[lane] * cone.cos[lane]);
}

BlockCones random_blocks(Rng& rng, bool gloss) {
  BlockCones blocks{.groups = std::vector<BlockCones::Group>(3), .any_gloss = gloss, .least_distance_squared = 1e-3f};
  for (BlockCones::Group& g : blocks.groups)
    for (std::size_t k = 0; k < kCutLanes; ++k) {
      for (int a = 0; a < 3; ++a) g.p[a][k] = rng.next();
      g.radius[k] = k % 2 == 0 ? 0.1f * rng.next() : 0.0f;
      set_random_cone(g.normal, k, rng), set_random_cone(g.mirror, k, rng);
      g.diffuse[k] = rng.next(), g.gloss[k] = 10 * rng.next(), g.any[k] = 0.1f * rng.next();
      g.inverse_alpha2[k] = k % 5 == 0 ? 0.0f : 1 / (0.01f + rng.next());
    }
  return blocks;
}

AxisFrame random_axis(Rng& rng) {
  const Frame frame(sample_sphere({rng.next(), rng.next()}));
  AxisFrame f{};
  for (int a = 0; a < 3; ++a) f.axis[a] = frame.n[a], f.s[a] = frame.s[a], f.t[a] = frame.t[a];
  return f;
}

CutCluster random_light(Rng& rng, int kind) {
  CutCluster c{};
  c.distant = kind == 3, c.has_cone = kind < 2;
  const Vec3 at = c.distant ? sample_sphere({rng.next(), rng.next()}) : Vec3{rng.next(), rng.next(), rng.next()};
  for (int a = 0; a < 3; ++a) c.lower[a] = c.upper[a] = at[a];
  c.back = random_axis(rng), c.mirror_back = random_axis(rng);
  c.cone_cos = 1, c.mirror_cos = 1;
  c.inverse_alpha2 = 30, c.diffuse = 2, c.gloss = kind == 1 ? 5.0f : 0.0f, c.any = kind == 1 ? 0.1f : 0.0f;
  return c;
}

TEST(BlockBounds, EqualTheirPlainTwinOnEveryInstructionSet) {
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    Rng rng({1}, Stage::test, 0);
    for (int round = 0; round < 200; ++round) {
      const BlockCones blocks = random_blocks(rng, round % 2 == 1);
      const CutCluster light = random_light(rng, round % 4);
      std::vector<float> got(48), expected(48);
      bound_blocks(blocks, light, got);
      bound_blocks_plain(blocks, light, expected);
      for (std::size_t k = 0; k < got.size(); ++k) {
        ASSERT_EQ(got[k], expected[k]) << "round " << round << ", block " << k;
        ASSERT_TRUE(got[k] >= 0 && std::isfinite(got[k]));
      }
    }
  }
  force_isa(0);
}

TEST(BlockBounds, SinglePointsAreBoundedAsInCuts) {
  // A block of one receiver, without gloss: the light cut's own bound of that pair.
  Rng rng({2}, Stage::test, 0);
  for (int round = 0; round < 500; ++round) {
    BlockCones blocks = random_blocks(rng, false);
    BlockCones::Group& g = blocks.groups[0];
    CutPoints points{.groups = std::vector<CutPoints::Group>(1), .least_distance_squared = 1e-3f};
    for (std::size_t k = 0; k < kCutLanes; ++k) {
      g.radius[k] = 0, g.normal.cos[k] = 1, g.normal.sin[k] = 0;
      const Frame frame(Vec3{g.normal.axis[0][k], g.normal.axis[1][k], g.normal.axis[2][k]});
      for (int a = 0; a < 3; ++a) {
        points.groups[0].p[a][k] = g.p[a][k];
        points.groups[0].normal[a][k] = frame.n[a];
        points.groups[0].normal[3 + a][k] = frame.s[a], points.groups[0].normal[6 + a][k] = frame.t[a];
      }
      points.groups[0].diffuse[k] = g.diffuse[k];
    }
    const CutCluster light = random_light(rng, 0);
    std::vector<float> bounds(48);
    bound_blocks(blocks, light, bounds);
    float lanes[kCutLanes];
    bound_lanes(points, 0, light, lanes);
    for (std::size_t k = 0; k < kCutLanes; ++k) ASSERT_NEAR(bounds[k], lanes[k], 1e-4f * (lanes[k] + 1e-2f));
  }
}

}  // namespace
}  // namespace myrialux
