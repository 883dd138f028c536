// One pass of one method over a frame: receivers and lights in, a radiance for each receiver out.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "myrialux/clusters/agglomerative_tree.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/completion/amc.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/completion/localized.h"
#include "myrialux/completion/matrix_separation.h"
#include "myrialux/report/stats.h"
#include "myrialux/visibility/approximate_radiance.h"
#include "myrialux/visibility/pair_sampler.h"

namespace myrialux {

/// LightSlice [ou11]; see docs/methods/lightslice.md.
struct LightSliceParams {
  std::uint32_t n_slices = 1500;    ///< at most; 64 rows at least each
  std::uint32_t n_neighbours = 8;   ///< slices whose rows judge a slice's clusters, itself included; 1 to 8
  float global_share = 0.3f;        ///< of --clusters: global clusters
  std::uint32_t n_dimensions = 50;  ///< of the projected columns that these are found from
  float local_share = 0;            ///< see DrawParams
  float power_share = 0;
};
/// Rows a slice, whole blocks.
std::uint32_t lightslice_rows(std::uint64_t n_receivers, std::uint32_t n_slices, std::uint32_t block_rows);

enum class TreeKind : std::uint8_t { agglomerative, divisive };

struct LightcutsParams {
  float error = 0.02f;   ///< as ReceiverCutParams; its largest size is CutParams::n_clusters
  bool together = true;  ///< 16 neighbours are refined in one order; false: each receiver in its own, as published
  TreeKind tree = TreeKind::agglomerative;
};

/// Knobs of illumination-cut and illumination-cut-sampling. Defaults as published.
struct IlluminationCutParams {
  float error = 0.015f;          ///< largest bound of a pair's error, as a share of the receivers' approximate radiance
  float sampling_error = 0.01f;  ///< the same of illumination-cut-sampling
  std::uint32_t normal_levels = 3;
  TreeKind tree = TreeKind::agglomerative;
  ApproximationParams approximation;  ///< its clamp distance and scene radius are the frame's
  SamplingParams sampling;
};

/// All knobs of all methods; which apply is in docs/methods. Settable by -D key=value (see parameter table).
struct MethodParams {
  SliceParams slices;
  LightTreeParams tree;
  CutParams cut;               ///< its clamp_distance is the clamp of bounds and shading alike
  bool auto_clusters = false;  ///< CutParams::n_clusters is chosen, see methods/auto_clusters.h
  LocalizedParams lbamc;
  /// Root mean square over pixels that lbamc's copies may add, over the mean radiance; 0: all entries are traced.
  float visibility_error = 0.005f;
  BamcParams bamc;
  LightSliceParams lightslice;
  bool bamc_cull = true;  ///< -D bamc.cull=false: trace entries whose transfer is zero, too (as published)
  float bamc_guard = 1;   ///< entries that may weigh more than this many times the mean are traced; 0: none (published)
  float mdlc_error = 0.02f;  ///< largest bound of a pair that is left, over the pixel's estimate
  LightcutsParams lightcuts;
  AmcParams amc;
  RowRates gauss_jordan;
  SeparationParams separation;
  /// As bamc_cull and bamc_guard, but without guard unless asked for: these methods are compared as published.
  bool amc_cull = true, gauss_jordan_cull = true, separation_cull = true;
  float amc_guard = 0, gauss_jordan_guard = 0, separation_guard = 0;
  IlluminationCutParams illumination_cut;
  RandomKey key;
};

/// What a method sees of the frame.
struct FrameView {
  const World& world;
  const Receivers& receivers;
  const VirtualLights& lights;
  float scene_radius = 0;  ///< of the bounding sphere, for normal weights
  int spp = 1;             ///< camera samples a pixel: receiver i is in pixel (first_sample + sample[i]) / spp
};

/// What it gives back; all indexed by receiver.
struct MethodResult {
  std::vector<Rgb> radiance;                         ///< light from virtual lights, beta not applied
  std::vector<std::uint32_t> slice;                  ///< slice id (slice methods), else empty
  std::vector<float> cut_size, visibility_fraction;  ///< of the receiver's slice, else empty
  /// The error meter's estimate for the receiver's slice, root mean square over the frame's mean radiance; 0 where the
  /// slice was traced whole. Empty: no meter.
  std::vector<float> visibility_error;
};

/// Adds counters and times to `stats`.
using Method = std::function<MethodResult(const FrameView&, const MethodParams&, Progress&, RenderStats&)>;

/// Does what depends on a pass's lights alone. Pixels may then be given to the method it returns in parts, each with
/// its own receivers: results are the same however they are parted.
using Preparation = std::function<Method(const World&, const VirtualLights&, float scene_radius, const MethodParams&,
                                         Progress&, RenderStats&)>;

/// What a render asks of its method besides the scene.
struct MethodRequest {
  bool lights_from_file = false;  ///< RenderParams::lights_file
  bool auto_clusters = false;     ///< RenderParams::auto_clusters
  bool visibility_error = false;  ///< RenderParams::visibility_error is given
};

struct MethodInfo {
  std::string name, summary, source;
  Method render;  ///< empty for `path`, which has no virtual lights
  /// What trades time for error: "clusters", or a -D key that is an error threshold; empty: nothing does.
  std::string knob = "clusters";
  /// What of a scene and request the method cannot do, as the end of a sentence ("render volumes"); empty: nothing.
  /// Not set: it can do all that scenes and requests may hold.
  std::function<std::string(const Scene&, const MethodRequest&)> cannot = {};
  std::uint32_t n_clusters = 1000;  ///< default of --clusters
  /// Of methods whose result for a pixel depends on no other pixel's receivers; else empty.
  Preparation prepare = {};
  bool keeps_to_error = false;  ///< takes account of MethodParams::visibility_error
};
/// All methods, in the order of the documentation.
const std::vector<MethodInfo>& all_methods();
/// @throws Error (usage) that lists the names.
const MethodInfo& find_method(const std::string& name);

/// Asked before any work. @throws Error (usage) if the method cannot do what is asked, with the names of those among
/// `all` that can
void require_able(const MethodInfo& method, const Scene& scene, const MethodRequest& request,
                  const std::vector<MethodInfo>& all = all_methods());

MethodResult render_lbamc(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_bamc(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_amc(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_gauss_jordan(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_matrix_separation(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_slice_lightcuts(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_lightcuts(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_mdlc(const FrameView&, const MethodParams&, Progress&, RenderStats&);
Method prepare_mdlc(const World&, const VirtualLights&, float scene_radius, const MethodParams&, Progress&,
                    RenderStats&);
MethodResult render_lightslice(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_illumination_cut(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_illumination_cut_sampling(const FrameView&, const MethodParams&, Progress&, RenderStats&);
MethodResult render_brute_force(const FrameView&, const MethodParams&, Progress&, RenderStats&);
Method prepare_brute_force(const World&, const VirtualLights&, float scene_radius, const MethodParams&, Progress&,
                           RenderStats&);

}  // namespace myrialux
