#include "values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "myrialux/base/error.h"
#include "myrialux/base/suggest.h"

namespace myrialux::app {
namespace {

/// The number that fills `text`, or nothing.
template <class T>
std::optional<T> parse_whole(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

[[noreturn]] void refuse(const std::string& flag, const std::string& text, const std::string& allowed) {
  throw Error(ErrorKind::usage, fmt::format("{} {}: allowed is {}", flag, text.empty() ? "''" : text, allowed));
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ',')
      parts.emplace_back();
    else if (c != ' ')
      parts.back() += c;
  return parts;
}

}  // namespace

CLI::Validator whole_number(std::int64_t low, std::int64_t high) {
  return {[=](const std::string& text) {
            const auto value = parse_whole<std::int64_t>(text);
            if (value && *value >= low && *value <= high) return std::string();
            return fmt::format("allowed is a whole number from {} to {}, got {}", low, high, text);
          },
          ""};
}

CLI::Validator whole_number_or(const std::string& word, std::int64_t low, std::int64_t high) {
  return {[=](const std::string& text) {
            const auto value = parse_whole<std::int64_t>(text);
            if (text == word || (value && *value >= low && *value <= high)) return std::string();
            return fmt::format("allowed is {} or a whole number from {} to {}, got {}", word, low, high, text);
          },
          ""};
}

CLI::Validator number(double low, double high, const std::string& unit) {
  return {[=](const std::string& text) {
            const auto value = parse_whole<double>(text);
            if (value && *value >= low && *value <= high) return std::string();
            return fmt::format("allowed is a number from {} to {}{}, got {}", low, high, unit.empty() ? "" : " " + unit,
                               text);
          },
          ""};
}

CLI::Validator one_of(std::vector<std::string> names) {
  return {[names = std::move(names)](const std::string& text) {
            if (std::find(names.begin(), names.end(), text) != names.end()) return std::string();
            return fmt::format("allowed is {}, got {}{}", fmt::join(names, ", "), text, did_you_mean(text, names));
          },
          ""};
}

Size parse_size(const std::string& flag, const std::string& text) {
  constexpr int kMax = 65536;
  const std::size_t x = text.find('x');
  if (x != std::string::npos) {
    const auto width = parse_whole<int>(text.substr(0, x)), height = parse_whole<int>(text.substr(x + 1));
    if (width && height && *width >= 1 && *width <= kMax && *height >= 1 && *height <= kMax) return {*width, *height};
  }
  refuse(flag, text, fmt::format("WIDTHxHEIGHT in pixels, each from 1 to {}, for example 1280x720", kMax));
}

std::uint64_t parse_bytes(const std::string& flag, const std::string& text) {
  const std::size_t end = std::min(text.find_first_not_of("0123456789."), text.size());
  std::string unit = text.substr(end);
  if (unit.ends_with("iB"))
    unit.resize(unit.size() - 2);
  else if (unit.ends_with("B"))
    unit.resize(unit.size() - 1);
  const auto value = parse_whole<double>(text.substr(0, end));
  const std::size_t power = std::string("KMGT").find(static_cast<char>(std::toupper(unit.empty() ? '?' : unit[0]))) + 1;
  const double bytes = value.value_or(0) * std::pow(1024.0, static_cast<double>(power));
  const bool is_unit_known = unit.empty() || (unit.size() == 1 && power > 0);
  if (!is_unit_known || !(bytes >= 1 && bytes < 1e18))
    refuse(flag, text, "bytes with K, M, G or T (powers of 1024), for example 2G");
  return static_cast<std::uint64_t>(bytes);
}

std::vector<float> parse_floats(const std::string& flag, const std::string& text, std::vector<std::size_t> counts,
                                const std::string& allowed) {
  std::vector<float> values;
  for (const std::string& part : split(text)) {
    const auto value = parse_whole<float>(part);
    if (!value || !std::isfinite(*value)) refuse(flag, text, allowed);
    values.push_back(*value);
  }
  if (std::find(counts.begin(), counts.end(), values.size()) == counts.end()) refuse(flag, text, allowed);
  return values;
}

std::vector<std::string> parse_names(const std::string& flag, const std::string& text,
                                     const std::vector<std::string>& allowed) {
  std::vector<std::string> names = split(text);
  for (const std::string& name : names)
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
      refuse(flag, text, fmt::format("a list of {}{}", fmt::join(allowed, ","), did_you_mean(name, allowed)));
  return names;
}

const std::vector<std::string>& filter_names() {
  static const std::vector<std::string> names = {"box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"};
  return names;
}

Filter named_filter(const std::string& name) {
  using Kind = Filter::Kind;
  if (name == "box") return {.kind = Kind::box, .radius = 0.5f};
  if (name == "tent") return {.kind = Kind::tent, .radius = 1};
  if (name == "mitchell") return {.kind = Kind::mitchell, .radius = 2};
  if (name == "catmullrom") return {.kind = Kind::catmullrom, .radius = 2};
  if (name == "lanczos") return {.kind = Kind::lanczos, .radius = 3};
  return {.kind = Kind::gaussian, .radius = 2, .sigma = 0.5f};
}

}  // namespace myrialux::app
