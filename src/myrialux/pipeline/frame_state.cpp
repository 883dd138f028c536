// Sums of a frame over its passes, and the picture made of them.
#include "myrialux/pipeline/frame_state.h"

#include <algorithm>

#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

/// What a method must tell for a layer to be there.
enum class Needs : std::uint8_t { nothing, slices, errors };

struct LayerKind {
  std::string name;
  std::vector<std::string> channels;
  Needs needs = Needs::nothing;
};

const std::vector<LayerKind>& layer_kinds() {
  static const std::vector<LayerKind> kinds = {{"", {"R", "G", "B"}},
                                               {"albedo", {"R", "G", "B"}},
                                               {"normal", {"X", "Y", "Z"}},
                                               {"depth", {"Z"}},
                                               {"slice", {"id"}, Needs::slices},
                                               {"cut", {"size"}, Needs::slices},
                                               {"visibility", {"fraction"}, Needs::slices},
                                               {"error", {"visibility"}, Needs::errors}};
  return kinds;
}

const LayerKind& layer_kind(const std::string& name) {
  const auto& kinds = layer_kinds();
  return *std::find_if(kinds.begin(), kinds.end(), [&](const LayerKind& kind) { return kind.name == name; });
}

/// Is a layer asked for, and can it be had?
bool has_layer(const LayerKind& kind, const std::vector<std::string>& aovs, bool has_slices, bool has_errors) {
  const bool is_known = kind.needs == Needs::nothing || (kind.needs == Needs::slices ? has_slices : has_errors);
  return is_known &&
         (kind.name.empty() || aovs.empty() || std::find(aovs.begin(), aovs.end(), kind.name) != aovs.end());
}

}  // namespace

FrameState::FrameState(int width, int height, const Filter& filter)
    : width_(width), height_(height), filter_(filter), pixels_(std::size_t(width) * std::size_t(height)) {
  sum_rgb_.resize(3 * pixels_.size());
  weight_.resize(pixels_.size());
}

void FrameState::add_first_hits(const CameraSamples& samples) {
  const std::size_t spp = static_cast<std::size_t>(samples.spp);
  PixelSums* const pixels = pixels_.data() + static_cast<std::size_t>(samples.first_row) * std::size_t(width_);
  parallel_for(
      samples.size() / spp,
      [&](std::size_t i) {
        PixelSums& pixel = pixels[i];
        for (std::size_t k = i * spp; k < (i + 1) * spp; ++k) {
          const Rgb albedo = samples.albedo[k];
          const Vec3 normal = samples.normal[k];
          pixel.albedo[0] += albedo.r, pixel.albedo[1] += albedo.g, pixel.albedo[2] += albedo.b;
          pixel.normal[0] += normal.x, pixel.normal[1] += normal.y, pixel.normal[2] += normal.z;
          ++pixel.n_samples;
          if (samples.depth[k] < kInfinity) pixel.depth += samples.depth[k], ++pixel.n_hits;
        }
      },
      4096);
}

void FrameState::add_radiance(const CameraSamples& samples, std::span<const Rgb> radiance) {
  accumulate(samples.position, radiance, width_, height_, samples.spp, filter_, sum_rgb_, weight_, samples.first_row);
}

void FrameState::add_slices(const Receivers& receivers, const MethodResult& method, int samples_a_pixel) {
  if (method.slice.empty()) return;
  const std::size_t spp = static_cast<std::size_t>(samples_a_pixel);
  has_slices_ = true;
  const bool has_errors = !method.visibility_error.empty();
  has_errors_ |= has_errors;
  // Receivers are ordered by camera sample, so those of a run of pixels lie together.
  constexpr std::size_t kPixels = 4096;
  parallel_for((pixels_.size() + kPixels - 1) / kPixels, [&](std::size_t block) {
    const auto first_of = [&](std::size_t pixel) {
      return std::lower_bound(receivers.sample.begin(), receivers.sample.end(), pixel * spp) - receivers.sample.begin();
    };
    const auto end = static_cast<std::size_t>(first_of((block + 1) * kPixels));
    for (auto i = static_cast<std::size_t>(first_of(block * kPixels)); i < end; ++i) {
      PixelSums& pixel = pixels_[receivers.sample[i] / spp];
      if (pixel.slice < 0) pixel.slice = static_cast<float>(method.slice[i]);
      pixel.cut += method.cut_size[i], pixel.visibility += method.visibility_fraction[i];
      if (has_errors) pixel.error += method.visibility_error[i];
      ++pixel.n_receivers;
    }
  });
}

std::size_t FrameState::n_channels(const std::vector<std::string>& aovs, bool has_slices, bool has_errors) {
  std::size_t n = 0;
  for (const LayerKind& kind : layer_kinds())
    if (has_layer(kind, aovs, has_slices, has_errors)) n += kind.channels.size();
  return n;
}

Picture FrameState::picture(const std::vector<std::string>& aovs) const {
  Picture picture;
  picture.width = width_, picture.height = height_;
  // Pixel by pixel: `fill(pixel, out)` writes the layer's channels.
  const auto add = [&](const char* name, auto&& fill) {
    const LayerKind& kind = layer_kind(name);
    if (!has_layer(kind, aovs, has_slices_, has_errors_)) return;
    const std::size_t n = kind.channels.size();
    Picture::Layer& layer = picture.add_layer(name, kind.channels);
    parallel_for(
        pixels_.size(), [&](std::size_t i) { fill(i, pixels_[i], layer.pixels.data() + n * i); }, 4096);
  };
  const auto mean = [](double sum, std::uint32_t n) { return n > 0 ? static_cast<float>(sum / n) : 0.0f; };

  add("", [&](std::size_t i, const PixelSums&, float* out) {
    // Filters with negative lobes can cancel where few samples fall; such a pixel has no defined value.
    for (int c = 0; c < 3; ++c)
      out[c] = weight_[i] != 0 ? static_cast<float>(sum_rgb_[3 * i + std::size_t(c)] / weight_[i]) : 0.0f;
  });
  add("albedo", [&](std::size_t, const PixelSums& p, float* out) {
    for (int c = 0; c < 3; ++c) out[c] = mean(p.albedo[c], p.n_samples);
  });
  add("normal", [&](std::size_t, const PixelSums& p, float* out) {
    for (int c = 0; c < 3; ++c) out[c] = mean(p.normal[c], p.n_samples);
  });
  add("depth", [&](std::size_t, const PixelSums& p, float* out) { out[0] = mean(p.depth, p.n_hits); });
  add("slice", [&](std::size_t, const PixelSums& p, float* out) { out[0] = p.slice; });
  add("cut", [&](std::size_t, const PixelSums& p, float* out) { out[0] = mean(p.cut, p.n_receivers); });
  add("visibility", [&](std::size_t, const PixelSums& p, float* out) { out[0] = mean(p.visibility, p.n_receivers); });
  add("error", [&](std::size_t, const PixelSums& p, float* out) { out[0] = mean(p.error, p.n_receivers); });
  return picture;
}

}  // namespace myrialux
