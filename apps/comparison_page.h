// FLIP and the HTML page of a comparison, by the Python package.
#pragma once

#include <string>

#include "myrialux/report/comparison.h"

namespace myrialux::app {

/// Evaluates FLIP of all images into `comparison`, and writes the page if `page` is not empty.
/// @throws Error (output) if Python, its packages or the page's place are missing
void add_flip_and_page(Comparison& comparison, const std::string& page);

}  // namespace myrialux::app
