// Reads virtual lights from a PLY point cloud: our own files exactly, files made elsewhere as oriented lights.
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "myrialux/lights/ply_columns.h"
#include "myrialux/lights/virtual_lights.h"
#include "myrialux/scene/ply_format.h"
#include "myrialux/scene/text.h"

namespace myrialux {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are read as they lie in memory");

struct Property {
  std::string name;
  PlyType type;
  std::optional<PlyColumn> column;  ///< none: not ours, skipped
};
struct Header {
  bool binary = false;
  std::uint64_t n_lights = 0;
  std::vector<Property> properties;
  std::array<bool, kPlyColumns> has{};
  std::map<int, MaterialId> materials;  ///< the comment table
  std::size_t body = 0;                 ///< byte where rows begin
  std::uint32_t lines = 0;              ///< of the header
};
using Row = std::array<double, kPlyColumns>;

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw Error(ErrorKind::input, place + ": " + what);
}
Header read_header(const std::string& text, const std::string& path, const Scene& scene);
void read_binary(const std::string& text, const std::string& path, const Header& header, auto&& take);
void read_ascii(const std::string& text, const std::string& path, const Header& header, auto&& take);
/// Appends one light; `place` is called only for a message.
void add_light(const Row& row, const Header& header, float default_offset, VirtualLights& lights, auto&& place);

}  // namespace

std::uint64_t count_lights(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  for (int k = 0; k < 1 << 16 && std::getline(in, line) && !line.starts_with("end_header"); ++k) {
    std::uint64_t n = 0;
    constexpr std::string_view kVertices = "element vertex ";
    if (line.starts_with(kVertices) &&
        std::from_chars(line.data() + kVertices.size(), line.data() + line.size(), n).ec == std::errc())
      return n;
  }
  return 0;
}

VirtualLights read_lights(const std::string& path, const Scene& scene) {
  const std::optional<std::string> bytes = read_file(path);
  if (!bytes) fail(path, "the file of virtual lights cannot be read");
  const std::string& text = *bytes;
  const Header header = read_header(text, path, scene);
  // Positions written by others need not lie exactly on our surfaces.
  const Box3 bounds = scene.bounds();
  const float default_offset = bounds.is_empty() ? 0 : 1e-4f * bounds.diagonal();
  VirtualLights lights;
  const auto take = [&](const Row& row, auto&& place) { add_light(row, header, default_offset, lights, place); };
  if (header.binary)
    read_binary(text, path, header, take);
  else
    read_ascii(text, path, header, take);
  return lights;
}

namespace {

/// "comment bsdf ENTRY MATERIAL NAME": the material must be the scene's.
void read_material(const std::vector<std::string_view>& words, std::string_view line, const std::string& place,
                   const Scene& scene, Header& header) {
  int entry = 0;
  std::uint32_t material = 0;
  const auto number = [&](std::string_view word, auto& out) {
    const auto r = std::from_chars(word.data(), word.data() + word.size(), out);
    return r.ec == std::errc() && r.ptr == word.data() + word.size();
  };
  if (words.size() < 4 || !number(words[2], entry) || !number(words[3], material))
    fail(place, "a material must be given as \"comment bsdf ENTRY MATERIAL NAME\"");
  std::size_t at = 0;  // the name is the rest of the line, blanks included
  for (int k = 0; k < 4; ++k) at = line.find(' ', line.find_first_not_of(' ', at));
  const std::string name(at == std::string_view::npos ? "" : line.substr(at + 1));
  if (material >= scene.materials.size() || scene.materials[material].name != name)
    fail(place, "these lights were made for another scene: material " + std::to_string(material) + " is '" + name +
                    "' there, and " +
                    (material < scene.materials.size() ? "'" + scene.materials[material].name + "'" : "missing") +
                    " here; make them anew with `myrialux lights`");
  header.materials[entry] = static_cast<MaterialId>(material);
}

void read_property(const std::vector<std::string_view>& words, const std::string& place, Header& header) {
  if (words.size() >= 2 && words[1] == "list") fail(place, "lights must not have list properties");
  const auto type = words.size() == 3 ? parse_ply_type(words[1]) : std::nullopt;
  if (!type)
    fail(place,
         "a property must be \"property TYPE NAME\" with a type of char, uchar, short, ushort, int, "
         "uint, float or double");
  if (words[2] == "radius" || words[2] == "x1")
    fail(place, "property '" + std::string(words[2]) +
                    "': sphere lights and ray lights cannot be rendered; only point lights can");
  Property property{std::string(words[2]), *type, std::nullopt};
  for (std::size_t c = 0; c < kPlyColumns; ++c)
    if (words[2] == kPlyNames[c]) {
      if (header.has[c]) fail(place, "property '" + std::string(words[2]) + "' is given twice");
      header.has[c] = true;
      property.column = static_cast<PlyColumn>(c);
    }
  header.properties.push_back(property);
}

void check_columns(const std::string& path, const Header& header) {
  const auto all = [&](PlyColumn first, PlyColumn end, bool any_counts, const char* what) {
    std::string missing;
    bool any = any_counts;
    for (auto c = static_cast<std::size_t>(first); c < static_cast<std::size_t>(end); ++c) {
      if (header.has[c])
        any = true;
      else
        missing += std::string(" ") + kPlyNames[c];
    }
    if (any && !missing.empty()) fail(path, std::string("the header lacks properties of ") + what + ":" + missing);
  };
  all(PlyColumn::x, PlyColumn::bounce, true, "every light (x y z nx ny nz r g b)");
  all(PlyColumn::ngx, PlyColumn::bsdf, false, "the geometric normal and offset");
  all(kFirstGlossy, kFirstSpot, false, "glossy lights");
  all(kFirstSpot, PlyColumn::count, false, "spot lights");
}

Header read_header(const std::string& text, const std::string& path, const Scene& scene) {
  Header header;
  bool has_format = false, in_vertex = false, has_vertex = false;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find('\n', at);
    ++header.lines;
    const std::string place = to_string(TextPosition{path, header.lines, 0});
    if (end == std::string::npos) fail(place, "not a PLY file, or it ends within the header");
    std::string_view line(text.data() + at, end - at);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at = end + 1;
    const std::vector<std::string_view> words = split_words(line);
    if (header.lines == 1) {
      if (line != "ply") fail(place, "a PLY file must begin with the line \"ply\"");
      continue;
    }
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      if (words.size() > 1 && words[1] == "bsdf") read_material(words, line, place, scene, header);
    } else if (words[0] == "format" && words.size() == 3) {
      if (words[1] != "ascii" && words[1] != "binary_little_endian")
        fail(place, "format '" + std::string(words[1]) + "' cannot be read; ascii and binary_little_endian can");
      header.binary = words[1] != "ascii", has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      in_vertex = words[1] == "vertex";
      if (!in_vertex && !has_vertex)
        fail(place, "element 'vertex' must come first, not '" + std::string(words[1]) + "'");
      if (!in_vertex) continue;
      const char* last = words[2].data() + words[2].size();
      const auto r = std::from_chars(words[2].data(), last, header.n_lights);
      if (has_vertex || r.ec != std::errc() || r.ptr != last || header.n_lights > 0x7fffffffu)
        fail(place,
             "the number of lights must be given once and be from 0 to 2^31 - 1, got '" + std::string(words[2]) + "'");
      has_vertex = true;
    } else if (words[0] == "property") {
      if (in_vertex) read_property(words, place, header);
    } else if (words[0] == "end_header") {
      header.body = at;
      break;
    } else {
      fail(place, "unknown header line '" + std::string(line.substr(0, 40)) + "'");
    }
  }
  if (!has_format) fail(path, "the header lacks a format line");
  if (!has_vertex) fail(path, "the header lacks an element 'vertex'");
  check_columns(path, header);
  return header;
}

void read_binary(const std::string& text, const std::string& path, const Header& header, auto&& take) {
  std::size_t stride = 0;
  for (const Property& p : header.properties) stride += size_of(p.type);
  const std::size_t left = text.size() - header.body;
  if (left < header.n_lights * stride)
    fail(path + ": byte " + std::to_string(text.size()),
         "the file ends within light " + std::to_string(left / stride) + " of " + std::to_string(header.n_lights));
  for (std::size_t j = 0; j < header.n_lights; ++j) {
    const std::size_t begin = header.body + j * stride;
    std::size_t at = begin;
    Row row{};
    for (const Property& p : header.properties) {
      if (p.column) row[static_cast<std::size_t>(*p.column)] = load_number(text.data() + at, p.type, false);
      at += size_of(p.type);
    }
    take(row, [&] { return path + ": byte " + std::to_string(begin) + " (light " + std::to_string(j) + ")"; });
  }
}

void read_ascii(const std::string& text, const std::string& path, const Header& header, auto&& take) {
  std::size_t at = header.body;
  std::uint32_t line = header.lines;
  for (std::size_t j = 0; j < header.n_lights;) {
    ++line;
    const auto place = [&] { return to_string(TextPosition{path, line, 0}); };
    if (at >= text.size())
      fail(place(), "the file ends at light " + std::to_string(j) + " of " + std::to_string(header.n_lights));
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::vector<std::string_view> words = split_words(std::string_view(text).substr(at, end - at));
    at = end + 1;
    if (words.empty()) continue;
    if (words.size() != header.properties.size())
      fail(place(), "a light must have " + std::to_string(header.properties.size()) + " numbers, got " +
                        std::to_string(words.size()));
    Row row{};
    for (std::size_t k = 0; k < words.size(); ++k) {
      double v = 0;
      const char* last = words[k].data() + words[k].size();
      const auto r = std::from_chars(words[k].data(), last, v);
      if (r.ec != std::errc() || r.ptr != last)
        fail(place(), "'" + std::string(words[k]) + "' is not a number that property '" + header.properties[k].name +
                          "' can hold");
      if (header.properties[k].column) row[static_cast<std::size_t>(*header.properties[k].column)] = v;
    }
    take(row, place);
    ++j;
  }
}

Vec3 vec3(const Row& row, PlyColumn first) {
  const auto c = static_cast<std::size_t>(first);
  return {static_cast<float>(row[c]), static_cast<float>(row[c + 1]), static_cast<float>(row[c + 2])};
}
Rgb rgb(const Row& row, PlyColumn first) {
  const Vec3 v = vec3(row, first);
  return {v.x, v.y, v.z};
}

/// A normal of a file: kept bit for bit if it is a unit vector already, else scaled.
Vec3 unit(Vec3 v, const char* name, bool needed, auto&& place) {
  const float squared = length_squared(v);
  if (!needed || std::fabs(squared - 1) < 1e-5f) return v;
  if (!(squared > 0) || !std::isfinite(squared))
    fail(place(), std::string(name) + " must be a direction of finite length > 0");
  return v / std::sqrt(squared);
}

void add_light(const Row& row, const Header& header, float default_offset, VirtualLights& lights, auto&& place) {
  const auto has = [&](PlyColumn c) { return header.has[static_cast<std::size_t>(c)]; };
  const auto number = [&](PlyColumn c) { return row[static_cast<std::size_t>(c)]; };
  for (std::size_t c = 0; c < kPlyColumns; ++c)
    if (!std::isfinite(static_cast<float>(row[c])))
      fail(place(), std::string(kPlyNames[c]) + " must be a finite number of single precision");
  const Rgb light = rgb(row, PlyColumn::r);
  if (light.r < 0 || light.g < 0 || light.b < 0) fail(place(), "r g b must be >= 0");
  const double bounce = has(PlyColumn::bounce) ? number(PlyColumn::bounce) : 1, kind_number = number(PlyColumn::kind);
  if (!(bounce >= 0 && bounce <= 255 && bounce == std::floor(bounce)))
    fail(place(), "bounce must be a whole number from 0 to 255");
  if (!(kind_number >= 0 && kind_number < kLightKinds && kind_number == std::floor(kind_number)))
    fail(place(), "kind must be 0 (oriented), 1 (glossy), 2 (point) or 3 (directional)");
  const auto kind = static_cast<LightKind>(static_cast<int>(kind_number));

  std::uint32_t extra = 0xffffffffu;
  if (kind == LightKind::glossy) {
    const auto material = header.materials.find(has(PlyColumn::bsdf) ? static_cast<int>(number(PlyColumn::bsdf)) : -1);
    if (material == header.materials.end())
      fail(place(), "the bsdf of a glossy light must be an entry of the header's \"comment bsdf\" table");
    extra = static_cast<std::uint32_t>(lights.glossy.size());
    lights.glossy.push_back({unit(vec3(row, PlyColumn::wix), "wix wiy wiz", true, place),
                             {material->second, static_cast<float>(number(PlyColumn::alpha)),
                              rgb(row, PlyColumn::diffuse_r), rgb(row, PlyColumn::specular_r)}});
  }
  if (kind == LightKind::point && has(PlyColumn::cos_cutoff) && number(PlyColumn::cos_cutoff) >= -1) {
    extra = static_cast<std::uint32_t>(lights.spots.size());
    lights.spots.push_back(
        {static_cast<float>(number(PlyColumn::cos_cutoff)), static_cast<float>(number(PlyColumn::cos_beam))});
  }
  const Vec3 n = unit(vec3(row, PlyColumn::nx), "nx ny nz", kind != LightKind::point || extra != 0xffffffffu, place);
  lights.p.push_back(vec3(row, PlyColumn::x));
  lights.n.push_back(n);
  lights.ng.push_back(
      has(PlyColumn::ngx) ? unit(vec3(row, PlyColumn::ngx), "ngx ngy ngz", kind <= LightKind::glossy, place) : n);
  lights.offset.push_back(has(PlyColumn::offset) ? static_cast<float>(number(PlyColumn::offset)) : default_offset);
  lights.light.push_back(light);
  lights.kind.push_back(kind);
  lights.bounce.push_back(static_cast<std::uint8_t>(bounce));
  lights.extra.push_back(extra);
}

}  // namespace
}  // namespace myrialux
