// Upper bounds of what clusters of lights send to receivers: one cluster against 16 receivers at once. [walter05, 4.1]
// All operations are correctly rounded ones in a fixed order, so every instruction set and the plain twin give the
// same bits, and a cut does not depend on the machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace myrialux {

inline constexpr std::size_t kCutLanes = 16;

/// A unit vector and two more that make it a right-handed frame.
struct AxisFrame {
  float axis[3], s[3], t[3];
};

/// Receivers at which bounds are taken: groups of 16, structure of arrays; unused lanes are all 0.
/// f(wi, wo) cos wi <= diffuse cos_n + gloss shape(mirror) [cos_n > 0] + any
struct CutPoints {
  struct alignas(64) Group {
    float p[3][kCutLanes];
    float normal[9][kCutLanes];  ///< AxisFrame, x y z of axis, s, t
    float mirror[9][kCutLanes];  ///< frame of the mirror direction of wo
    float diffuse[kCutLanes], gloss[kCutLanes], any[kCutLanes];
    float inverse_alpha2[kCutLanes], c1[kCutLanes], c2[kCutLanes], c3[kCutLanes], t_least[kCutLanes];  ///< shape()
  };
  std::vector<Group> groups;
  bool any_gloss = false;            ///< false: mirror and shape are not looked at
  float least_distance_squared = 0;  ///< clamp distance squared; > 0
};

/// A cluster of lights. Intensity along w <= diffuse cos(axis cone) + gloss shape(mirror cone) [cos > 0] + any.
struct CutCluster {
  float lower[3], upper[3];  ///< of positions; distant: of directions towards the light
  AxisFrame back;            ///< frame of minus the axis of the normal cone
  float cone_cos, cone_sin;
  AxisFrame mirror_back;  ///< the same for mirror directions
  float mirror_cos, mirror_sin;
  float inverse_alpha2;  ///< of the gloss; shape coefficients 1, 1/2, 0
  float diffuse, gloss, any;
  bool distant, has_cone;  ///< has_cone false: diffuse counts in all directions
};

/// Largest bound of each cluster over all points.
void bound_clusters(const CutPoints& points, std::span<const CutCluster> clusters, std::span<float> bounds);
void bound_clusters_plain(const CutPoints& points, std::span<const CutCluster> clusters, std::span<float> bounds);

/// Largest bound of one cluster over each group of points: `bounds` is [points.groups.size()].
void bound_groups(const CutPoints& points, const CutCluster& cluster, std::span<float> bounds);
void bound_groups_plain(const CutPoints& points, const CutCluster& cluster, std::span<float> bounds);

/// Bounds of one cluster at each of the 16 points of one group.
void bound_lanes(const CutPoints& points, std::size_t group, const CutCluster& cluster,
                 std::span<float, kCutLanes> bounds);
void bound_lanes_plain(const CutPoints& points, std::size_t group, const CutCluster& cluster,
                       std::span<float, kCutLanes> bounds);

}  // namespace myrialux
