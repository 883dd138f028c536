// How far a picture is from a reference of the same size: one set of measures on luminance, one on R G B.
// Sources: relMSE [rousselle11], FLIP is left to its published package (python/myrialux/flip.py). Measures of
// outliers and of the room without its windows: ours, after docs/measurements.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "myrialux/math/vec.h"

namespace myrialux {

inline constexpr double kRelmseEpsilon = 1e-2;     ///< added to the squared reference, (W m^-2 sr^-1)^2
inline constexpr std::size_t kWorstOneIn = 1000;   ///< n / kWorstOneIn worst pixels are left out, rounded down
inline constexpr double kRoomTimesMedian = 10;     ///< brighter pixels of the reference are windows and lamps
inline constexpr double kDiffersFromShare = 0.05;  ///< of the reference's mean

/// Measures over pixels of c channels: c = 1 for luminance, 3 for R G B. Means run over pixels and channels.
/// "Relative" means over the reference's mean; NaN where that mean is not above 0.
struct ErrorMeasures {
  double mean_reference = 0, mean = 0;
  double bias = 0;                         ///< (mean - mean_reference) / mean_reference, signed
  double rmse = 0;                         ///< sqrt of the mean squared difference
  double mae = 0;                          ///< mean absolute difference
  double relative_rmse = 0;                ///< rmse / mean_reference
  double relative_rmse_without_worst = 0;  ///< the same without the worst 0.1 % of the pixels; divisor as before
  double relative_rmse_room = 0;           ///< without_worst over pixels whose reference luminance is at most 10 times
                                           ///< its median, over their own mean
  double relmse = 0;                       ///< mean of (difference^2 / (reference^2 + epsilon))
  std::uint64_t differing_pixels = 0;      ///< a channel differs by more than 5 % of mean_reference
  double differing_share = 0;              ///< of all pixels
  double psnr_db = 0;  ///< after exposure, cut to 0 to 1 and sRGB curve; infinite for equal pictures
};

struct ImageErrors {
  ErrorMeasures luminance, rgb;
  std::array<double, 3> mean_rgb_reference{}, mean_rgb{};  ///< means of R, G, B
};

/// Both pictures finite, of one size, at least one pixel. Sums run in the order of the pixels, in double.
/// @param exposure stops, for psnr_db alone
ImageErrors image_errors(std::span<const Rgb> reference, std::span<const Rgb> image, double exposure = 0);

/// What a measure is called and means, in the order in which it is told.
struct MeasureInfo {
  std::string key;   ///< in JSON
  std::string name;  ///< a few words, for tables
  std::string unit;  ///< "%": told times 100; "dB"; "": radiance or a plain number
  std::string meaning;
  std::optional<bool> smaller_is_better;  ///< none: neither way
  double (*value)(const ErrorMeasures&);
};
const std::vector<MeasureInfo>& measure_table();

}  // namespace myrialux
