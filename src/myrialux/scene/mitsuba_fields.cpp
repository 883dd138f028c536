// Typed access to properties: wrong types and values are told, unread ones warned of.
#include "myrialux/scene/mitsuba_fields.h"

#include <fmt/format.h>

#include <algorithm>

#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

const Property* Fields::property(const std::string& name) {
  asked_.push_back(name);
  for (const Property& p : object_.properties)
    if (p.name == name) {
      p.used = true;
      return &p;
    }
  return nullptr;
}

const Child* Fields::child(const std::string& name) {
  asked_.push_back(name);
  for (const Child& c : object_.children)
    if (c.name == name) {
      c.used = true;
      return &c;
    }
  return nullptr;
}

bool Fields::has(const std::string& name) {
  return std::any_of(object_.properties.begin(), object_.properties.end(),
                     [&](const Property& p) { return p.name == name; }) ||
         std::any_of(object_.children.begin(), object_.children.end(), [&](const Child& c) { return c.name == name; });
}

TextPosition Fields::at(const std::string& name) const {
  for (const Property& p : object_.properties)
    if (p.name == name) return p.at;
  for (const Child& c : object_.children)
    if (c.name == name) return c.at;
  return object_.at;
}

void Fields::wrong_type(const Property& p, const std::string& allowed) {
  found_.error(p.at, fmt::format("\"{}\" is a <{}>; allowed: {}", p.spelled, p.tag, allowed));
}

double Fields::number(const std::string& name, double missing, const Range& range) {
  const Property* p = property(name);
  if (!p) return missing;
  double value = missing;
  if (const double* number = std::get_if<double>(&p->value))
    value = *number;
  else if (const std::int64_t* whole = std::get_if<std::int64_t>(&p->value))
    value = static_cast<double>(*whole);
  else
    return wrong_type(*p, "<float>"), missing;
  if (value < range.lower || value > range.upper || (range.lower_open && value == range.lower)) {
    std::string told = range.told;
    if (told.empty()) told = fmt::format("{} to {}", show(range.lower), show(range.upper));
    error(name, fmt::format("\"{}\" is {}; allowed: {}", p->spelled, show(value), told));
    return missing;
  }
  return value;
}

std::int64_t Fields::integer(const std::string& name, std::int64_t missing, std::int64_t lower, std::int64_t upper) {
  const Property* p = property(name);
  if (!p) return missing;
  const std::int64_t* value = std::get_if<std::int64_t>(&p->value);
  if (!value) return wrong_type(*p, "<integer>"), missing;
  if (*value >= lower && *value <= upper) return *value;
  error(name, fmt::format("\"{}\" is {}; allowed: {} to {}", p->spelled, *value, lower, upper));
  return missing;
}

bool Fields::boolean(const std::string& name, bool missing) {
  const Property* p = property(name);
  if (!p) return missing;
  if (const bool* value = std::get_if<bool>(&p->value)) return *value;
  return wrong_type(*p, "<boolean>"), missing;
}

std::string Fields::text(const std::string& name, const std::string& missing) {
  const Property* p = property(name);
  if (!p) return missing;
  if (const std::string* value = std::get_if<std::string>(&p->value)) return *value;
  return wrong_type(*p, "<string>"), missing;
}

std::string Fields::choice(const std::string& name, const std::string& missing,
                           const std::vector<std::string>& allowed) {
  std::string value = text(name, missing);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  error(name, fmt::format("\"{}\" is \"{}\"{}; allowed: {}", property(name)->spelled, value, suggestion(value, allowed),
                          fmt::join(allowed, ", ")));
  return missing;
}

Vec3 Fields::vector(const std::string& name, Vec3 missing) {
  const Property* p = property(name);
  if (!p) return missing;
  if (const Vec3* value = std::get_if<Vec3>(&p->value)) return *value;
  return wrong_type(*p, "<point>, <vector>"), missing;
}

Transform Fields::transform(const std::string& name) {
  const Property* p = property(name);
  if (!p) return {};
  if (const Transform* value = std::get_if<Transform>(&p->value)) return *value;
  return wrong_type(*p, "<transform>"), Transform();
}

void Fields::ignore(const std::vector<std::string>& names) {
  for (const std::string& name : names) property(name);
}

void Fields::finish() {
  const std::string what = fmt::format("{} \"{}\"", object_.tag, object_.spelled_type);
  for (const Property& p : object_.properties)
    if (!p.used) {
      p.used = true;  // told once, though the object may be read again for another reference
      found_.warning(
          p.at, fmt::format("{} does not know the parameter \"{}\"{}", what, p.spelled, suggestion(p.name, asked_)));
    }
  for (const Child& c : object_.children)
    if (!c.used && c.object) {
      c.used = true;
      found_.warning(c.at, c.spelled.empty() ? fmt::format("{} has no use for <{} type=\"{}\">", what, c.object->tag,
                                                           c.object->spelled_type)
                                             : fmt::format("{} does not know the parameter \"{}\"{}", what, c.spelled,
                                                           suggestion(c.name, asked_)));
    }
}

void accept_all(const Object& object) {
  for (const Property& p : object.properties) p.used = true;
  for (const Child& c : object.children) c.used = true;
}

}  // namespace myrialux::mitsuba
