// Pictures against a reference: reads and checks the files, measures each, and tells it as JSON.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "myrialux/film/film.h"
#include "myrialux/report/image_errors.h"

namespace myrialux {

/// A rectangle of pixels; x, y count from the top left.
struct Region {
  int x = 0, y = 0, width = 0, height = 0;
};

struct ComparedPicture {
  std::string path, name;   ///< name: the file's stem where that is unique, else the path
  Metadata header;          ///< text attributes of an EXR
  std::vector<Rgb> pixels;  ///< those of the region, row by row
};

/// What the FLIP package used, as it tells it.
struct FlipSettings {
  double pixels_per_degree = 0, start_exposure = 0, stop_exposure = 0;  ///< exposures in stops
  int n_exposures = 0;
  std::string tone_mapper;
};

struct Comparison {
  int width = 0, height = 0;  ///< of the whole pictures
  Region region;              ///< that was compared
  double exposure = 0;        ///< stops, for what depends on how pictures are shown
  ComparedPicture reference;
  struct Image {
    ComparedPicture picture;
    ImageErrors errors;
    /// Mean FLIP of the HDR pictures [andersson21] and of the pictures as shown [andersson20]; NaN: not evaluated.
    double flip = std::numeric_limits<double>::quiet_NaN(), flip_shown = std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<Image> images;  ///< in the order given
  std::optional<FlipSettings> flip;
};

struct ComparisonOptions {
  double exposure = 0;
  std::optional<Region> region;  ///< default: all
};

/// @throws Error (input) listing all that is wrong with all files: unreadable, no R G B, not finite, another size than
/// the reference, a region that reaches out
Comparison compare_pictures(const std::string& reference, const std::vector<std::string>& images,
                            const ComparisonOptions& options = {});

/// Positions in `images`, smallest relative RMSE of luminance first; equals stay in their order.
std::vector<std::size_t> by_error(const Comparison& comparison);

/// The JSON text, keys as in docs/formats.md. What is undefined or was not evaluated is null.
std::string to_json(const Comparison& comparison);

}  // namespace myrialux
