// Reads Mitsuba's property elements into typed values; every malformed value is told with its place.
#include "myrialux/scene/mitsuba_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

namespace {

const std::vector<std::string> kPropertyTags = {"float", "integer",  "boolean", "string",    "vector",    "point",
                                                "rgb",   "spectrum", "srgb",    "blackbody", "transform", "animation"};
const std::vector<std::string> kTransformTags = {"translate", "rotate", "scale", "lookat", "matrix"};

/// One property element and what is known about it.
struct Reader {
  const pugi::xml_node& node;
  const PropertyContext& context;
  std::string tag = node.name();
  std::string text(const char* name) const { return node.attribute(name).as_string(); }
  bool has(const char* name) const { return node.attribute(name); }
  std::string label() const { return fmt::format("{} \"{}\"", tag, text("name")); }
  void error(const std::string& what) const { context.found.error(context.at(node), what); }
  void check_attributes(std::vector<std::string> allowed) const;
};

std::optional<Value> read_value(const Reader& in);
std::optional<Vec3> read_xyz(const Reader& in, double missing);
std::optional<ColorValue> read_rgb(const Reader& in);
std::optional<ColorValue> read_spectrum(const Reader& in);
std::optional<ColorValue> read_typed_spectrum(const Reader& in);
std::optional<Transform> read_transform(const Reader& in);
std::optional<Animation> read_animation(const Reader& in);

}  // namespace

const std::vector<std::string>& property_tags() { return kPropertyTags; }

bool is_property_tag(const std::string& tag) {
  return std::find(kPropertyTags.begin(), kPropertyTags.end(), tag) != kPropertyTags.end();
}

std::optional<Property> read_property(const pugi::xml_node& node, const PropertyContext& context) {
  const Reader in{node, context};
  std::optional<Value> value = read_value(in);
  const std::string spelled = in.text("name");
  if (spelled.empty()) {
    in.error(fmt::format("<{}> needs the attribute name", in.tag));
    return {};
  }
  if (!value) return {};
  return Property{context.old_names ? to_snake_case(spelled) : spelled, spelled, in.tag, context.at(node),
                  std::move(*value)};
}

namespace {

void Reader::check_attributes(std::vector<std::string> allowed) const {
  for (const pugi::xml_attribute& a : node.attributes()) {
    const std::string name = a.name();
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
      error(fmt::format("<{}> has an unknown attribute {}; allowed: {}", tag, name, fmt::join(allowed, ", ")));
  }
}

template <class T>
std::optional<Value> as_value(const std::optional<T>& value) {
  if (!value) return {};
  return Value(*value);
}

std::optional<Value> read_value(const Reader& in) {
  if (in.tag == "vector" || in.tag == "point") {
    in.check_attributes({"name", "value", "x", "y", "z"});
    return as_value(read_xyz(in, 0));
  }
  if (in.tag == "transform") {
    in.check_attributes({"name"});
    return as_value(read_transform(in));
  }
  if (in.tag == "animation") return as_value(read_animation(in));
  if (in.tag == "rgb" || in.tag == "srgb") return as_value(read_rgb(in));
  if (in.tag == "spectrum") return as_value(in.has("type") ? read_typed_spectrum(in) : read_spectrum(in));
  if (in.tag == "blackbody") return as_value(read_spectrum(in));
  in.check_attributes({"name", "value"});
  const std::string text = in.text("value");
  if (!in.has("value")) return in.error(in.label() + " needs the attribute value"), std::nullopt;
  if (in.tag == "string") return Value(text);
  if (in.tag == "float") {
    if (const auto number = parse_number(text)) return Value(*number);
    return in.error(fmt::format("{} is \"{}\"; allowed: a finite number", in.label(), text)), std::nullopt;
  }
  if (in.tag == "integer") {
    if (const auto number = parse_integer(text)) return Value(*number);
    return in.error(fmt::format("{} is \"{}\"; allowed: a whole number", in.label(), text)), std::nullopt;
  }
  const std::string_view word = trim(text);
  if (word == "true" || word == "True") return Value(true);
  if (word == "false" || word == "False") return Value(false);
  return in.error(fmt::format("{} is \"{}\"; allowed: true, false", in.label(), text)), std::nullopt;
}

/// From value="x y z" (or one number for all three), or from the attributes x, y, z.
std::optional<Vec3> read_xyz(const Reader& in, double missing) {
  double xyz[3] = {missing, missing, missing};
  if (in.has("value")) {
    const auto numbers = parse_numbers(in.text("value"));
    if (!numbers || (numbers->size() != 3 && numbers->size() != 1))
      return in.error(
                 fmt::format("<{}> value is \"{}\"; allowed: three numbers, or one for all", in.tag, in.text("value"))),
             std::nullopt;
    for (std::size_t c = 0; c < 3; ++c) xyz[c] = (*numbers)[numbers->size() == 3 ? c : 0];
  } else {
    const char* names[3] = {"x", "y", "z"};
    for (int c = 0; c < 3; ++c) {
      if (!in.has(names[c])) continue;
      const auto number = parse_number(in.text(names[c]));
      if (!number)
        return in.error(
                   fmt::format("<{}> {} is \"{}\"; allowed: a finite number", in.tag, names[c], in.text(names[c]))),
               std::nullopt;
      xyz[c] = *number;
    }
  }
  return Vec3{static_cast<float>(xyz[0]), static_cast<float>(xyz[1]), static_cast<float>(xyz[2])};
}

double linear_of_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

/// One or three numbers, or #rrggbb. The tag srgb of the old dialect, and hexadecimal digits, carry the sRGB curve.
std::optional<ColorValue> read_rgb(const Reader& in) {
  in.check_attributes({"name", "value"});
  const std::string text(trim(in.text("value")));
  double rgb[3];
  bool is_curved = in.tag == "srgb";
  if (text.starts_with("#")) {
    const bool is_hex =
        text.size() == 7 && std::all_of(text.begin() + 1, text.end(), [](unsigned char c) { return std::isxdigit(c); });
    if (!is_hex)
      return in.error(fmt::format("{} is \"{}\"; allowed: # and six hexadecimal digits", in.label(), text)),
             std::nullopt;
    for (int c = 0; c < 3; ++c) rgb[c] = std::stoi(text.substr(1 + 2 * c, 2), nullptr, 16) / 255.0;
    is_curved = true;
  } else {
    const auto numbers = parse_numbers(text);
    if (!numbers || (numbers->size() != 1 && numbers->size() != 3))
      return in.error(fmt::format("{} is \"{}\"; allowed: one or three numbers, or #rrggbb", in.label(), text)),
             std::nullopt;
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = (*numbers)[numbers->size() == 3 ? c : 0];
  }
  if (is_curved)
    for (double& v : rgb) v = linear_of_srgb(v);
  ColorValue color;
  color.rgb = {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
  return color;
}

/// Constant, or "wavelength:value, ..." in nm; blackbody of the old dialect: temperature="5000K" scale="1".
std::optional<ColorValue> read_spectrum(const Reader& in) {
  ColorValue color;
  if (in.tag == "blackbody") {
    in.check_attributes({"name", "temperature", "scale"});
    std::string kelvin(trim(in.text("temperature")));
    if (kelvin.ends_with('K') || kelvin.ends_with('k')) kelvin.pop_back();
    const auto temperature = parse_number(kelvin);
    const auto scale = in.has("scale") ? parse_number(in.text("scale")) : 1.0;
    if (!temperature || !(*temperature > 0) || !scale)
      return in.error(fmt::format("{}: allowed: temperature in kelvin above 0, scale a finite number", in.label())),
             std::nullopt;
    color.kind = ColorValue::Kind::blackbody, color.temperature_k = *temperature, color.constant = *scale;
    return color;
  }
  in.check_attributes({"name", "value"});
  const std::string text = in.text("value");
  if (text.find(':') == std::string::npos) {
    const auto number = parse_number(text);
    if (!number)
      return in.error(fmt::format("{} is \"{}\"; allowed: a number, or wavelength:value pairs", in.label(), text)),
             std::nullopt;
    color.kind = ColorValue::Kind::constant, color.constant = *number;
    return color;
  }
  color.kind = ColorValue::Kind::samples;
  std::string_view rest = text;
  while (!(rest = trim(rest)).empty()) {
    const std::size_t colon = rest.find(':');
    const auto wavelength = parse_number(rest.substr(0, colon));
    if (colon == rest.npos || !wavelength) break;
    rest = trim(rest.substr(colon + 1));
    const std::size_t end = std::min(rest.find_first_of(" ,\t\r\n"), rest.size());
    const auto value = parse_number(rest.substr(0, end));
    if (!value || (!color.samples.empty() && !(*wavelength > color.samples.back().first))) break;
    color.samples.emplace_back(*wavelength, *value);
    rest = trim(rest.substr(end));
    if (rest.starts_with(',')) rest.remove_prefix(1);
    if (rest.empty() && color.samples.size() > 1) return color;
  }
  in.error(fmt::format("{}: allowed: at least two wavelength:value pairs with rising wavelengths in nm", in.label()));
  return {};
}

/// <spectrum type="..."> with properties inside, as Mitsuba 2 and 3 write blackbodies and uniform spectra.
std::optional<ColorValue> read_typed_spectrum(const Reader& in) {
  in.check_attributes({"name", "type"});
  const std::string type = in.text("type");
  ColorValue color;
  double temperature = 5000, scale = 1;
  for (const pugi::xml_node& child : in.node.children()) {
    if (child.type() != pugi::node_element) continue;
    const std::string name = to_snake_case(child.attribute("name").as_string());
    const Reader part{child, in.context};
    const auto number = parse_number(part.text("value"));
    const bool is_known =
        name == "scale" || (type == "blackbody" && name == "temperature") || (type != "blackbody" && name == "value");
    if (!is_known || part.tag != "float" || !number)
      part.error(fmt::format("{} in a {} spectrum; allowed: <float name=\"{}\"/>, <float name=\"scale\"/>",
                             part.label(), type, type == "blackbody" ? "temperature" : "value"));
    else
      (name == "temperature" ? temperature : scale) = *number;
  }
  if (type == "blackbody" && temperature > 0) {
    color.kind = ColorValue::Kind::blackbody, color.temperature_k = temperature, color.constant = scale;
    return color;
  }
  if (type == "uniform" || type == "d65") {  // white in Rec. 709
    color.rgb = gray(static_cast<float>(scale));
    return color;
  }
  in.error(type == "blackbody" ? in.label() + ": allowed: a temperature above 0 kelvin"
                               : fmt::format("unknown spectrum \"{}\"; allowed: blackbody, d65, uniform", type));
  return {};
}

std::optional<Transform> read_step(const Reader& in) {
  const std::string tag = to_snake_case(in.tag) == "look_at" ? "lookat" : in.tag;
  if (tag == "translate" || tag == "scale") {
    in.check_attributes({"value", "x", "y", "z"});
    const auto xyz = read_xyz(in, tag == "scale" ? 1 : 0);
    if (!xyz) return {};
    return tag == "scale" ? Transform::scale(*xyz) : Transform::translate(*xyz);
  }
  if (tag == "rotate") {
    in.check_attributes({"value", "x", "y", "z", "angle"});
    const auto axis = read_xyz(in, 0);
    const auto angle = parse_number(in.text("angle"));
    if (!axis) return {};
    if (!angle) return in.error("<rotate> needs an angle in degrees"), std::nullopt;
    if (!(length(*axis) > 0)) return in.error("<rotate> needs an axis that is not 0"), std::nullopt;
    return Transform::rotate(*axis, static_cast<float>(*angle));
  }
  if (tag == "matrix") {
    in.check_attributes({"value"});
    const auto m = parse_numbers(in.text("value"));
    if (!m || (m->size() != 16 && m->size() != 9))
      return in.error("<matrix> needs a value of 9 or 16 numbers"), std::nullopt;
    std::array<double, 16> rows{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const int n = m->size() == 16 ? 4 : 3;
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c) rows[4 * r + c] = (*m)[n * r + c];
    const Transform transform(rows);
    if (!transform.is_affine()) return in.error("<matrix> needs 0 0 0 1 as its last row"), std::nullopt;
    return transform;
  }
  if (tag == "lookat") {
    in.check_attributes({"origin", "target", "up"});
    Vec3 p[3];
    const char* names[3] = {"origin", "target", "up"};
    for (int i = 0; i < 3; ++i) {
      const auto numbers = parse_numbers(in.text(names[i]));
      if (!numbers || numbers->size() != 3)
        return in.error(fmt::format("<{}> {} is \"{}\"; allowed: three numbers", in.tag, names[i], in.text(names[i]))),
               std::nullopt;
      p[i] = {static_cast<float>((*numbers)[0]), static_cast<float>((*numbers)[1]), static_cast<float>((*numbers)[2])};
    }
    if (!(length(p[1] - p[0]) > 0) || !(length(cross(p[2], normalize(p[1] - p[0]))) > 1e-6f * length(p[2])))
      return in.error(fmt::format("<{}>: origin and target must differ and up must not point along the view", in.tag)),
             std::nullopt;
    return Transform::look_at(p[0], p[1], p[2]);
  }
  in.error(fmt::format("unknown element <{}> in a transform{}; allowed: {}", in.tag, suggestion(in.tag, kTransformTags),
                       fmt::join(kTransformTags, ", ")));
  return {};
}

/// The product of the steps; the first one is applied first.
std::optional<Transform> read_transform(const Reader& in) {
  Transform transform;
  bool is_good = true;
  for (const pugi::xml_node& child : in.node.children()) {
    if (child.type() != pugi::node_element) continue;
    const std::optional<Transform> step = read_step({child, in.context});
    if (step)
      transform = *step * transform;
    else
      is_good = false;
  }
  if (!is_good) return {};
  const auto& m = transform.rows();
  double scale = 1;
  for (int r = 0; r < 3; ++r) scale *= std::hypot(m[4 * r], m[4 * r + 1], m[4 * r + 2]);
  const bool is_finite = std::all_of(m.begin(), m.end(), [](double v) { return std::abs(v) < 1e30; });
  const std::string name = to_snake_case(in.text("name"));
  if (!is_finite || (name == "to_world" && !(std::abs(transform.determinant3()) > 1e-12 * scale)))
    return in.error(
               fmt::format("transform \"{}\" cannot be inverted; allowed: scales that are not 0", in.text("name"))),
           std::nullopt;
  return transform;
}

std::optional<Animation> read_animation(const Reader& in) {
  in.check_attributes({"name"});
  Animation animation;
  bool is_good = true;
  for (const pugi::xml_node& child : in.node.children()) {
    if (child.type() != pugi::node_element) continue;
    const Reader key{child, in.context};
    key.check_attributes({"time"});
    const std::optional<double> time = parse_number(key.text("time"));
    std::optional<Transform> to_world;
    if (key.tag != "transform")
      key.error(fmt::format("unknown element <{}> in an animation; allowed: transform", key.tag));
    else if (!time)
      key.error(fmt::format("<transform> of an animation has time \"{}\"; allowed: a finite number", key.text("time")));
    else
      to_world = read_transform(key);
    if (to_world)
      animation.keys.push_back({*time, *to_world, in.context.at(child)});
    else
      is_good = false;
  }
  if (is_good && animation.keys.empty())
    in.error(in.label() + " is empty; allowed: two <transform time=\"...\"> and more");
  if (!is_good || animation.keys.empty()) return {};
  return animation;
}

}  // namespace

}  // namespace myrialux::mitsuba
