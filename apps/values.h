// Values of flags as they are typed: what is allowed, and what they mean.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "myrialux/math/filter.h"
#include "myrialux/math/vec.h"

namespace myrialux::app {

/// Checks for CLI11 that say what is allowed and what came.
CLI::Validator whole_number(std::int64_t low, std::int64_t high);
CLI::Validator whole_number_or(const std::string& word, std::int64_t low, std::int64_t high);
CLI::Validator number(double low, double high, const std::string& unit = "");
CLI::Validator one_of(std::vector<std::string> names);

struct Size {
  int width = 0, height = 0;
};
// The following throw Error (usage) that names `flag`.
Size parse_size(const std::string& flag, const std::string& text);  ///< "1280x720"
std::uint64_t parse_bytes(const std::string& flag,
                          const std::string& text);  ///< "2G", "512M", "1.5GiB"; powers of 1024
/// Numbers apart from each other by commas; as many as one of `counts`.
std::vector<float> parse_floats(const std::string& flag, const std::string& text, std::vector<std::size_t> counts,
                                const std::string& allowed);
std::vector<std::string> parse_names(const std::string& flag, const std::string& text,
                                     const std::vector<std::string>& allowed);
/// A filter of its usual width.
Filter named_filter(const std::string& name);
const std::vector<std::string>& filter_names();

}  // namespace myrialux::app
