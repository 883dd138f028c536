// The one place that knows which Embree is used (3.13 or 4): query contexts, query calls, callback arguments.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define MYRIALUX_EMBREE4 1
#else
#include <embree3/rtcore.h>
#define MYRIALUX_EMBREE4 0
#endif

namespace myrialux {

template <int N>
struct RayPacketOf;
template <>
struct RayPacketOf<4> {
  using type = RTCRay4;
};
template <>
struct RayPacketOf<8> {
  using type = RTCRay8;
};
template <>
struct RayPacketOf<16> {
  using type = RTCRay16;
};
template <int N>
using RayPacket = typename RayPacketOf<N>::type;

#if MYRIALUX_EMBREE4
using EmbreeContext = RTCRayQueryContext;
inline void init_context(EmbreeContext& context) { rtcInitRayQueryContext(&context); }
#else
using EmbreeContext = RTCIntersectContext;
inline void init_context(EmbreeContext& context) { rtcInitIntersectContext(&context); }
#endif

/// Sets what is the same for all rays of a packet: all but origins, directions and tfar.
inline void init_rays(RTCRay16& rays) {
  for (unsigned k = 0; k < 16; ++k)
    rays.tnear[k] = 0, rays.time[k] = 0, rays.mask[k] = 0xffffffffu, rays.id[k] = k, rays.flags[k] = 0;
}

/// Closest hit of one ray, treated as incoherent.
inline void embree_intersect(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
#if MYRIALUX_EMBREE4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
#else
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect1(scene, &context, &ray);
#endif
}

/// Occlusion of one ray (N = 1) or of the lanes of a packet whose `valid` is -1; blocked lanes get tfar = -infinity.
template <int N, class Rays>
void embree_occluded(const int* valid, RTCScene scene, EmbreeContext& context, Rays& rays, bool coherent) {
#if MYRIALUX_EMBREE4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  if constexpr (N == 1) rtcOccluded1(scene, &rays, &arguments);
  if constexpr (N == 4) rtcOccluded4(valid, scene, &rays, &arguments);
  if constexpr (N == 8) rtcOccluded8(valid, scene, &rays, &arguments);
  if constexpr (N == 16) rtcOccluded16(valid, scene, &rays, &arguments);
#else
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  if constexpr (N == 1) rtcOccluded1(scene, &context, &rays);
  if constexpr (N == 4) rtcOccluded4(valid, scene, &context, &rays);
  if constexpr (N == 8) rtcOccluded8(valid, scene, &context, &rays);
  if constexpr (N == 16) rtcOccluded16(valid, scene, &context, &rays);
#endif
  (void)valid;
}

}  // namespace myrialux
