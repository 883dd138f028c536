// The page of a bench, made by python/myrialux/bench.py.
#pragma once

#include <vector>

#include "bench_records.h"
#include "myrialux/math/vec.h"

namespace myrialux::app {

/// R G B of a picture file, row by row. @throws Error (input)
std::vector<Rgb> read_pixels(const std::string& path);

/// Evaluates FLIP of every picture into `results` and writes the page.
/// @throws Error (output) naming what Python lacks
void write_bench_page(const BenchFolder& folder, std::vector<BenchResult>& results, const std::string& page);

}  // namespace myrialux::app
