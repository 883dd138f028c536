// Names the user may have meant: the nearest by edits (insert, delete, replace, swap of neighbours).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace myrialux {

/// Least number of edits that turn a into b (optimal string alignment). Cost: a.size() * b.size().
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The allowed name nearest to `name`, or "" if none is within a third of its length (at least 2 edits).
std::string nearest_name(std::string_view name, const std::vector<std::string>& allowed);

/// "; did you mean x?", or "" when nothing is near.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& allowed);

}  // namespace myrialux
