// Typed values of Mitsuba's property elements: <float>, <rgb>, <transform>, ...
#pragma once

#include <functional>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "myrialux/scene/mitsuba_tree.h"

namespace myrialux::mitsuba {

struct PropertyContext {
  bool old_names = false;  ///< camelCase dialect
  std::function<TextPosition(const pugi::xml_node&)> at;
  Diagnostics& found;
};

const std::vector<std::string>& property_tags();
bool is_property_tag(const std::string& tag);
/// Nothing after a mistake, which has been reported.
std::optional<Property> read_property(const pugi::xml_node& node, const PropertyContext& context);

}  // namespace myrialux::mitsuba
