// Textures, colours and slots of Mitsuba scenes.
#include <fmt/format.h>

#include "myrialux/scene/mitsuba_reader.h"
#include "myrialux/scene/spectrum.h"
#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

namespace {

Texture read_bitmap(Reader& in, Fields& fields);
Texture read_checkerboard(Fields& fields);
Transform read_to_uv(Fields& fields);
Rgb checked(Fields& fields, const Property& property, Rgb color, Rgb missing, ColorUse use);
ColorSlot texture_slot(Reader& in, Fields& fields, const Child& child, Rgb missing);

}  // namespace

Rgb to_rgb(const ColorValue& color, ColorUse use) {
  const bool is_emission = use == ColorUse::emission;
  switch (color.kind) {
    case ColorValue::Kind::rgb:
      return color.rgb;
    case ColorValue::Kind::constant:
      // the same power at all wavelengths is not white under D65: Mitsuba shows it as it is
      return is_emission ? equal_energy_rgb() * static_cast<float>(color.constant)
                         : gray(static_cast<float>(color.constant));
    case ColorValue::Kind::samples:
      return is_emission ? emission_rgb(color.samples) : reflectance_rgb(color.samples, use != ColorUse::metal_index);
    case ColorValue::Kind::blackbody:
      break;
  }
  return blackbody_rgb(color.temperature_k) * static_cast<float>(color.constant);
}

Rgb read_color(Fields& fields, const std::string& name, Rgb missing, ColorUse use) {
  const Property* p = fields.property(name);
  if (!p) {
    if (const Child* child = fields.child(name))
      fields.found().error(child->at,
                           fmt::format("\"{}\" is a texture; allowed: <rgb>, <float>, <spectrum>", child->spelled));
    return missing;
  }
  if (const double* number = std::get_if<double>(&p->value))
    return checked(fields, *p, gray(static_cast<float>(*number)), missing, use);
  if (const ColorValue* color = std::get_if<ColorValue>(&p->value))
    return checked(fields, *p, to_rgb(*color, use), missing, use);
  fields.wrong_type(*p, "<rgb>, <float>, <spectrum>");
  return missing;
}

ColorSlot read_slot(Reader& in, Fields& fields, const std::string& name, Rgb missing, ColorUse use) {
  if (!fields.property(name))
    if (const Child* child = fields.child(name))
      return child->object ? texture_slot(in, fields, *child, missing) : ColorSlot{missing};
  return {read_color(fields, name, missing, use)};
}

ColorSlot read_scalar_slot(Reader& in, Fields& fields, const std::string& name, float missing, const Range& range) {
  const Property* p = fields.property(name);
  if (!p) {
    const Child* child = fields.child(name);
    return child && child->object ? texture_slot(in, fields, *child, gray(missing)) : ColorSlot{gray(missing)};
  }
  if (const ColorValue* color = std::get_if<ColorValue>(&p->value)) {
    const float value = color->kind == ColorValue::Kind::constant ? static_cast<float>(color->constant)
                                                                  : luminance(to_rgb(*color, ColorUse::factor));
    if (value >= range.lower && value <= range.upper && !(range.lower_open && value == range.lower))
      return {gray(value)};
    fields.error(name, fmt::format("\"{}\" is {}; allowed: {}", p->spelled, show(value), range.told));
    return {gray(missing)};
  }
  return {gray(static_cast<float>(fields.number(name, missing, range)))};
}

std::string read_filename(Reader& in, Fields& fields) {
  const std::string name = fields.text("filename", "");
  if (name.empty()) {
    fields.found().error(fields.object().at,
                         fmt::format("{} \"{}\" needs a filename", fields.object().tag, fields.object().spelled_type));
    return {};
  }
  return resolve(in.tree, fields.object().folder, name).string();
}

TextureId read_texture(Reader& in, const Object& object) {
  const auto [place, is_new] = in.textures.try_emplace(&object, kNone<TextureId>);
  if (!is_new) return place->second;
  Fields fields(object, in.found);
  Texture texture;
  if (object.type == "bitmap" || object.type == "ldrtexture") {
    texture = read_bitmap(in, fields);
  } else if (object.type == "checkerboard") {
    texture = read_checkerboard(fields);
  } else {
    report_type(in, object, {"bitmap", "checkerboard"},
                {"mesh_attribute", "vertexcolors", "gridtexture", "wireframe", "curvature", "volume", "scale"});
    return kNone<TextureId>;
  }
  texture.to_uv = read_to_uv(fields) * texture.to_uv;
  fields.ignore({"max_anisotropy", "cache", "format", "accel"});
  fields.finish();
  if (texture.kind == Texture::Kind::bitmap && !texture.image) return kNone<TextureId>;
  texture.name = object.id.empty() ? texture.name : object.id;
  in.scene.textures.push_back(std::move(texture));
  return place->second = static_cast<TextureId>(in.scene.textures.size() - 1);
}

namespace {

Rgb checked(Fields& fields, const Property& p, Rgb color, Rgb missing, ColorUse use) {
  const float low = std::min({color.r, color.g, color.b}), high = max_component(color);
  const bool is_bounded = use == ColorUse::reflectance;
  if (low >= 0 && (!is_bounded || high <= 1)) return color;
  fields.found().error(p.at, fmt::format("\"{}\" is {}, {}, {}; allowed: {}", p.spelled, show(color.r), show(color.g),
                                         show(color.b), is_bounded ? "0 to 1" : "0 and above"));
  return missing;
}

/// Texture, or the 0.6 adapter "scale": a texture times a number.
ColorSlot texture_slot(Reader& in, Fields& fields, const Child& child, Rgb missing) {
  const Object& object = *child.object;
  if (object.tag != "texture") {
    fields.found().error(child.at,
                         fmt::format("\"{}\" is a {}; allowed: a colour or a texture", child.spelled, object.tag));
    return {missing};
  }
  if (object.type != "scale") {
    const TextureId texture = read_texture(in, object);
    return texture == kNone<TextureId> ? ColorSlot{missing} : ColorSlot{gray(1), texture};
  }
  Fields scale(object, in.found);
  const float factor = static_cast<float>(scale.number("scale", 1, {0, 1e30}));
  ColorSlot slot{missing};
  for (const Child& inner : object.children)
    if (inner.object) {
      inner.used = true;
      slot = texture_slot(in, fields, inner, missing);
    }
  scale.finish();
  slot.value = slot.value * factor;
  return slot;
}

Texture::Wrap wrap_of(const std::string& name) {
  return name == "mirror" ? Texture::Wrap::mirror : name == "clamp" ? Texture::Wrap::clamp : Texture::Wrap::repeat;
}

Texture read_bitmap(Reader& in, Fields& fields) {
  Texture texture;
  const std::string path = read_filename(in, fields);
  const bool raw = fields.boolean("raw", false);
  double gamma = fields.number("gamma", 0, {-1, 10});
  const std::string filter = fields.choice("filter_type", "bilinear", {"bilinear", "nearest", "trilinear", "ewa"});
  texture.filter = filter == "nearest" ? Texture::Filter::nearest : Texture::Filter::bilinear;
  std::string wrap = fields.choice("wrap_mode", "repeat", {"repeat", "mirror", "clamp"});
  if (fields.has("wrap_mode_u") || fields.has("wrap_mode_v")) {
    const std::string u = fields.choice("wrap_mode_u", wrap, {"repeat", "mirror", "clamp"});
    const std::string v = fields.choice("wrap_mode_v", wrap, {"repeat", "mirror", "clamp"});
    if (u != v)
      fields.found().unsupported(fields.at("wrap_mode_u"),
                                 "bitmap: different wrapModeU and wrapModeV cannot be rendered; allowed: equal modes");
    wrap = u;
  }
  texture.wrap = wrap_of(wrap);
  if (path.empty()) return texture;
  texture.name = fields.text("filename", "");
  const bool is_linear = raw || gamma == 1;
  if (gamma < 0) gamma = 0;
  texture.image =
      in.assets.add_image(path, is_linear, is_linear ? 0 : static_cast<float>(gamma), fields.at("filename"));
  return texture;
}

Texture read_checkerboard(Fields& fields) {
  Texture texture;
  texture.kind = Texture::Kind::checkerboard;
  texture.name = "checkerboard";
  texture.color0 = read_color(fields, "color0", gray(0.4f), ColorUse::factor);
  texture.color1 = read_color(fields, "color1", gray(0.2f), ColorUse::factor);
  return texture;
}

/// to_uv, and the scale and offset of the 0.6 dialect.
Transform read_to_uv(Fields& fields) {
  Transform to_uv = fields.transform("to_uv");
  const double scale = fields.number("uvscale", 1);
  const Vec3 scales{static_cast<float>(fields.number("uscale", scale)),
                    static_cast<float>(fields.number("vscale", scale)), 1};
  const Vec3 offsets{static_cast<float>(fields.number("uoffset", 0)), static_cast<float>(fields.number("voffset", 0)),
                     0};
  return to_uv * Transform::translate(offsets) * Transform::scale(scales);
}

}  // namespace

}  // namespace myrialux::mitsuba
