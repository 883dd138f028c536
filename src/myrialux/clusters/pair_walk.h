// Walks down a point tree and a light tree at once, from the pair of their roots to pairs that pass a test. [bus15,
// algorithm 1] Point nodes come one after another, each with the list of light nodes that wait there, so that what all
// pairs of a point node share is made once, and subtrees of points are independent tasks.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "myrialux/clusters/light_tree.h"
#include "myrialux/clusters/point_tree.h"

namespace myrialux {

/// Subtrees of at most so many receivers are walked by one thread.
inline constexpr std::uint32_t kWalkTaskPoints = 1 << 12;

enum class PairVerdict : std::uint8_t {
  done,          ///< accepted, or nothing to add
  split_lights,  ///< the light node's children take its place
  split_points,  ///< the pair goes on to the point node's children
};

/// Light nodes that wait at the point nodes between the root and the present one, list behind list.
struct PairLists {
  std::vector<std::uint32_t> waiting, stack;
};

/// Judges all pairs of a point node with the light nodes waiting[first ..]: calls judge(light node) until each is done
/// or waits for the point node's children. Those are appended to `waiting`; order: depth first, left before right.
template <class Judge>
void judge_pairs(const LightTree& lights, std::size_t first, PairLists& lists, const Judge& judge) {
  const std::size_t end = lists.waiting.size();
  for (std::size_t k = first; k < end; ++k) {
    lists.stack.push_back(lists.waiting[k]);
    while (!lists.stack.empty()) {
      const std::uint32_t node = lists.stack.back();
      lists.stack.pop_back();
      switch (judge(node)) {
        case PairVerdict::done:
          break;
        case PairVerdict::split_lights:
          lists.stack.push_back(lights.inner[node].right);
          lists.stack.push_back(lights.inner[node].left);
          break;
        case PairVerdict::split_points:
          lists.waiting.push_back(node);
          break;
      }
    }
  }
}

/// Ball around a box.
struct Ball {
  Vec3 centre;
  float radius = 0;
  explicit Ball(const Box3& box) : centre(box.centre()), radius(0.5f * box.diagonal()) {}
};

/// Ball of a light node; distant lights stand at `far`, a length of the scene's size, in their directions.
inline Ball light_ball(const LightNode& node, float far) {
  Ball ball(node.box);
  if (node.kind == LightKind::directional) ball.radius *= far;
  return ball;
}

/// Distance between the surfaces of two balls; distant lights: `far`.
inline float ball_distance(const Ball& points, const Ball& lights, LightKind kind, float far) {
  if (kind == LightKind::directional) return far;
  return std::max(0.0f, length(points.centre - lights.centre) - points.radius - lights.radius);
}

}  // namespace myrialux
