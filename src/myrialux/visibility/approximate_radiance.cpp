// Walks both trees from the root of the points down; sums stay at the nodes, and come down to the leaves and back up as
// minima on the way. [bus15, 3, phase I]
#include "myrialux/visibility/approximate_radiance.h"

#include <algorithm>
#include <array>
#include <bit>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/pair_walk.h"
#include "myrialux/trace/tracer.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

constexpr std::size_t kLanes = 16;

class Approximation {
 public:
  Approximation(const World& world, const Receivers& receivers, const VirtualLights& lights,
                const LightTree& light_tree, const ApproximationParams& params, PointTree& points)
      : world_(world),
        receivers_(receivers),
        lights_(lights),
        light_tree_(light_tree),
        params_(params),
        points_(points),
        far_(2 * params.scene_radius),
        cone_cos_(std::cos(0.5f * params.aperture_deg * kPi / 180)) {}

  /// The node with light nodes waiting[first ..]; `inherited` came to it from above. Takes its lists off again.
  ApproximationCounters visit(std::uint32_t node, float inherited, std::size_t first, PairLists& lists) const;

 private:
  /// Shadow rays from one representative that wait until they fill a packet.
  struct Packet {
    Segments<kLanes> segments{};
    std::array<float, kLanes> value{};  ///< luminance
    int n = 0;
    float sum = 0;
    ApproximationCounters counters;
  };
  PairVerdict judge(const PointNode& point, const Ball& ball, std::uint32_t light, Packet& packet) const;
  void add(ReceiverId receiver, const LightNode& light, Packet& packet) const;
  void flush(Packet& packet) const;
  ApproximationCounters visit_children(std::uint32_t node, float inherited, std::size_t first, PairLists& lists) const;

  const World& world_;
  const Receivers& receivers_;
  const VirtualLights& lights_;
  const LightTree& light_tree_;
  const ApproximationParams& params_;
  PointTree& points_;
  float far_, cone_cos_;
};

}  // namespace

ApproximationCounters approximate_radiance(const World& world, const Receivers& receivers, const VirtualLights& lights,
                                           const LightTree& light_tree, const ApproximationParams& params,
                                           PointTree& points) {
  if (points.nodes.empty()) return {};
  PairLists lists;
  lists.waiting = light_tree.roots;
  return Approximation(world, receivers, lights, light_tree, params, points).visit(0, 0, 0, lists);
}

namespace {

ApproximationCounters Approximation::visit(std::uint32_t index, float inherited, std::size_t first,
                                           PairLists& lists) const {
  PointNode& point = points_.nodes[index];
  const Ball ball(point.box);
  const std::size_t end = lists.waiting.size();
  Packet packet;
  judge_pairs(light_tree_, first, lists, [&](std::uint32_t light) { return judge(point, ball, light, packet); });
  flush(packet);
  point.colour = inherited + packet.sum;
  ApproximationCounters counters = packet.counters;
  if (!point.is_leaf()) {
    const ApproximationCounters below = visit_children(index, point.colour, end, lists);
    counters.pairs += below.pairs, counters.rays += below.rays;
  }
  lists.waiting.resize(end);
  return counters;
}

ApproximationCounters Approximation::visit_children(std::uint32_t index, float inherited, std::size_t first,
                                                    PairLists& lists) const {
  PointNode& point = points_.nodes[index];
  std::array<ApproximationCounters, 8> counters;
  if (point.count > kWalkTaskPoints) {
    parallel_for(point.n_children, [&](std::size_t k) {
      PairLists own;
      own.waiting.assign(lists.waiting.begin() + static_cast<std::ptrdiff_t>(first), lists.waiting.end());
      counters[k] = visit(point.children + static_cast<std::uint32_t>(k), inherited, 0, own);
    });
  } else {
    for (std::uint32_t k = 0; k < point.n_children; ++k)
      counters[k] = visit(point.children + k, inherited, first, lists);
  }
  point.colour = kInfinity;
  ApproximationCounters sum;
  for (std::uint32_t k = 0; k < point.n_children; ++k) {
    point.colour = std::min(point.colour, points_.nodes[point.children + k].colour);
    sum.pairs += counters[k].pairs, sum.rays += counters[k].rays;
  }
  return sum;
}

PairVerdict Approximation::judge(const PointNode& point, const Ball& ball, std::uint32_t index, Packet& packet) const {
  const LightNode light = light_tree_.node(index);
  const Ball lights = light_ball(light, far_);
  const bool has_cone = light.kind == LightKind::oriented || light.kind == LightKind::glossy;
  const bool is_narrow = !has_cone || light.cone_cos > cone_cos_ || light.is_leaf();
  const float largest = params_.radius * ball_distance(ball, lights, light.kind, far_);
  const bool is_small = std::max(ball.radius, lights.radius) < largest;
  if ((is_small && is_narrow) || (point.is_leaf() && light.is_leaf())) {
    ++packet.counters.pairs;
    add(point.representative, light, packet);
    return PairVerdict::done;
  }
  // The larger one is divided; a cone that is too wide is the lights' matter.
  if (light.is_leaf()) return PairVerdict::split_points;
  if (point.is_leaf() || lights.radius > ball.radius || is_small) return PairVerdict::split_lights;
  return PairVerdict::split_points;
}

void Approximation::add(ReceiverId receiver, const LightNode& node, Packet& packet) const {
  const LightId light = node.representative;
  const float weight = node.importance / light_tree_.importance[index(light)];
  const float value =
      weight * luminance(transfer(world_, receivers_, receiver, lights_, light, params_.clamp_distance));
  if (!(value > 0)) return;
  const Segment s = shadow_segment(receivers_, receiver, lights_, light);
  ++packet.counters.rays;
  if (s.distant) {
    if (!world_.tracer.occluded_direction(s.from, s.to)) packet.sum += value;
    return;
  }
  const int k = packet.n++;
  packet.value[static_cast<std::size_t>(k)] = value;
  packet.segments.from_x[k] = s.from.x, packet.segments.from_y[k] = s.from.y, packet.segments.from_z[k] = s.from.z;
  packet.segments.to_x[k] = s.to.x, packet.segments.to_y[k] = s.to.y, packet.segments.to_z[k] = s.to.z;
  if (packet.n == static_cast<int>(kLanes)) flush(packet);
}

void Approximation::flush(Packet& packet) const {
  if (packet.n == 0) return;
  const std::uint32_t valid = packet.n == 32 ? ~0u : (1u << packet.n) - 1;
  const std::uint32_t blocked = world_.tracer.occluded_packet<kLanes>(packet.segments, valid, false);
  for (std::uint32_t bits = valid & ~blocked; bits != 0; bits &= bits - 1)
    packet.sum += packet.value[static_cast<std::size_t>(std::countr_zero(bits))];
  packet.n = 0;
}

}  // namespace
}  // namespace myrialux
