// Reads Stanford PLY meshes: ascii, binary little and big endian; polygons become fans of triangles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "myrialux/scene/mesh.h"
#include "myrialux/scene/ply_format.h"
#include "myrialux/scene/text.h"

namespace myrialux {

namespace {

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  bool is_list = false;
  PlyType count_type = PlyType::u8;
};
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};
enum class Encoding { ascii, little, big };
struct PlyHeader {
  Encoding encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  std::size_t size = 0;       ///< bytes
  std::uint32_t n_lines = 0;  ///< lines of the header
};

/// A mistake in the file, told by exception inside this reader only.
struct Broken {
  TextPosition at;
  std::string what;
};

/// Reads numbers one after the other from the body.
class Body {
 public:
  Body(const std::string& path, std::string_view bytes, const PlyHeader& header)
      : path_(path), bytes_(bytes), at_(header.size), line_(header.n_lines), encoding_(header.encoding) {}
  double next(PlyType type);
  std::size_t left() const { return bytes_.size() - at_; }
  const char* here() const { return bytes_.data() + at_; }
  void skip(std::size_t n) { at_ += n; }
  [[noreturn]] void fail(const std::string& what) const;

 private:
  double next_word(PlyType type);
  const std::string& path_;
  std::string_view bytes_;
  std::size_t at_;
  std::uint32_t line_;
  Encoding encoding_;
};

PlyHeader read_header(const std::string& path, std::string_view bytes);
void read_vertices(const PlyElement& element, Encoding encoding, Body& body, Mesh& mesh);
void read_faces(const PlyElement& element, Body& body, Mesh& mesh);
void skip_element(const PlyElement& element, Body& body);

}  // namespace

Mesh read_ply(const std::string& path, Diagnostics& found) {
  Mesh mesh;
  const std::optional<std::string> bytes = read_file(path);
  if (!bytes) return found.error({path, 0, 0}, "cannot be read"), mesh;
  try {
    const PlyHeader header = read_header(path, *bytes);
    Body body(path, *bytes, header);
    for (const PlyElement& element : header.elements) {
      // a row takes at least one byte a property (ascii: a digit and a blank), so the file bounds what is allocated
      if (element.count > 0 && element.properties.empty()) body.fail("element " + element.name + " has no properties");
      if (element.count > body.left() / std::max<std::size_t>(element.properties.size(), 1) + 1)
        body.fail(
            fmt::format("the header promises {} rows of {}, more than the file can hold", element.count, element.name));
      if (element.name == "vertex")
        read_vertices(element, header.encoding, body, mesh);
      else if (element.name == "face")
        read_faces(element, body, mesh);
      else
        skip_element(element, body);
    }
    for (const std::uint32_t v : mesh.indices)
      if (v >= mesh.positions.size())
        throw Broken{{path, 0, 0},
                     fmt::format("a face names vertex {}; allowed: 0 to {}", v,
                                 static_cast<std::int64_t>(mesh.positions.size()) - 1)};
    if (const std::size_t v = first_non_finite(mesh); v < mesh.positions.size())
      throw Broken{{path, 0, 0}, fmt::format("vertex {} is not finite", v)};
  } catch (const Broken& broken) {
    found.error(broken.at, broken.what);
  }
  return mesh;
}

namespace {

PlyProperty read_property_line(const std::vector<std::string_view>& words, const TextPosition& at) {
  PlyProperty p;
  const bool is_list = words.size() == 5 && words[1] == "list";
  const auto type = words.size() >= 3 ? parse_ply_type(is_list ? words[3] : words[1]) : std::nullopt;
  const auto count_type = is_list ? parse_ply_type(words[2]) : std::optional(PlyType::u8);
  if (!type || !count_type || (!is_list && words.size() != 3) || *count_type >= PlyType::f32)
    throw Broken{at, "allowed: property TYPE NAME, property list COUNT_TYPE TYPE NAME"};
  return {std::string(words.back()), *type, is_list, *count_type};
}

PlyHeader read_header(const std::string& path, std::string_view bytes) {
  PlyHeader header;
  bool has_format = false;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    const TextPosition place{path, ++header.n_lines, 0};
    const std::vector<std::string_view> words = split_words(bytes.substr(at, end - at));
    at = end + 1;
    if (header.n_lines == 1) {
      if (words.empty() || words[0] != "ply") throw Broken{place, "not a PLY file: the first line must be \"ply\""};
      continue;
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      if (!has_format) throw Broken{place, "the header has no format line"};
      header.size = std::min(at, bytes.size());
      return header;
    }
    if (words[0] == "format" && words.size() >= 2) {
      has_format = true;
      if (words[1] == "ascii")
        header.encoding = Encoding::ascii;
      else if (words[1] == "binary_little_endian")
        header.encoding = Encoding::little;
      else if (words[1] == "binary_big_endian")
        header.encoding = Encoding::big;
      else
        throw Broken{place, "unknown format; allowed: ascii, binary_little_endian, binary_big_endian"};
    } else if (words[0] == "element" && words.size() == 3) {
      const auto count = parse_integer(words[2]);
      if (!count || *count < 0 || *count > 0xfffffff0LL)
        throw Broken{place, fmt::format("element count is \"{}\"; allowed: 0 to {}", words[2], 0xfffffff0LL)};
      header.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), {}});
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property_line(words, place));
    } else {
      throw Broken{place, fmt::format("unknown header line \"{}\"; allowed: format, element, property, comment, "
                                      "obj_info, end_header",
                                      std::string(words[0]).substr(0, 40))};
    }
  }
  throw Broken{{path, header.n_lines, 0}, "the header has no end_header"};
}

void Body::fail(const std::string& what) const {
  if (encoding_ == Encoding::ascii) throw Broken{{path_, line_ + 1, 0}, what};
  throw Broken{{path_, 0, 0}, fmt::format("byte {}: {}", at_, what)};
}

double Body::next(PlyType type) {
  if (encoding_ == Encoding::ascii) return next_word(type);
  const std::size_t size = size_of(type);
  if (left() < size) fail("the file ends too early");
  const double value = load_number(here(), type, encoding_ == Encoding::big);
  at_ += size;
  return value;
}

double Body::next_word(PlyType type) {
  while (at_ < bytes_.size() && (bytes_[at_] == ' ' || (bytes_[at_] >= '\t' && bytes_[at_] <= '\r')))
    line_ += bytes_[at_++] == '\n';
  const std::size_t start = at_;
  while (at_ < bytes_.size() && bytes_[at_] != ' ' && !(bytes_[at_] >= '\t' && bytes_[at_] <= '\r')) ++at_;
  if (start == at_) fail("the file ends too early");
  const std::string_view word = bytes_.substr(start, at_ - start);
  const auto value = parse_number(word);
  if (!value || (type < PlyType::f32 && *value != std::floor(*value)))
    fail(fmt::format("\"{}\" is not a finite number", std::string(word.substr(0, 40))));
  return *value;
}

/// Which field of the mesh a vertex property fills: 0-2 position, 3-5 normal, 6-7 uv, -1 none.
int target_of(const std::string& name) {
  static const std::map<std::string, int> targets = {
      {"x", 0}, {"y", 1}, {"z", 2}, {"nx", 3},        {"ny", 4},        {"nz", 5},        {"u", 6},
      {"v", 7}, {"s", 6}, {"t", 7}, {"texture_u", 6}, {"texture_v", 7}, {"texture_s", 6}, {"texture_t", 7}};
  const auto found = targets.find(name);
  return found == targets.end() ? -1 : found->second;
}

void read_vertices(const PlyElement& element, Encoding encoding, Body& body, Mesh& mesh) {
  std::vector<int> target;
  unsigned present = 0;
  bool is_plain = encoding == Encoding::little;  // only floats: rows can be copied
  std::size_t row_size = 0;
  for (const PlyProperty& p : element.properties) {
    target.push_back(p.is_list ? -1 : target_of(p.name));
    if (target.back() >= 0) present |= 1u << target.back();
    is_plain = is_plain && !p.is_list && p.type == PlyType::f32;
    row_size += size_of(p.type);
  }
  if ((present & 7) != 7) body.fail("vertices need the properties x, y, z");
  const bool has_normals = (present & 0x38) == 0x38, has_uvs = (present & 0xc0) == 0xc0;
  if (is_plain && element.count > body.left() / row_size) body.fail("the file ends too early");
  const std::size_t n = element.count;
  mesh.positions.resize(n);
  if (has_normals) mesh.normals.resize(n);
  if (has_uvs) mesh.uvs.resize(n);
  float value[8] = {};
  std::vector<float> row(element.properties.size());
  for (std::size_t v = 0; v < n; ++v) {
    if (is_plain) {
      std::memcpy(row.data(), body.here(), row_size);
      body.skip(row_size);
    }
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& p = element.properties[i];
      if (p.is_list) {
        const double n_items = body.next(p.count_type);
        if (n_items < 0) body.fail("a list has a negative length");
        for (double k = 0; k < n_items; ++k) body.next(p.type);
        continue;
      }
      const float number = is_plain ? row[i] : static_cast<float>(body.next(p.type));
      if (target[i] >= 0) value[target[i]] = number;
    }
    mesh.positions[v] = {value[0], value[1], value[2]};
    if (has_normals) mesh.normals[v] = {value[3], value[4], value[5]};
    if (has_uvs) mesh.uvs[v] = {value[6], value[7]};
  }
}

void read_faces(const PlyElement& element, Body& body, Mesh& mesh) {
  const auto is_corner_list = [](const PlyProperty& p) {
    return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
  };
  if (std::none_of(element.properties.begin(), element.properties.end(), is_corner_list))
    body.fail("faces need the property list vertex_indices");
  mesh.indices.reserve(std::min<std::size_t>(3 * element.count, body.left()));
  std::vector<std::uint32_t> corners;
  for (std::uint64_t f = 0; f < element.count; ++f)
    for (const PlyProperty& p : element.properties) {
      const double n_items = p.is_list ? body.next(p.count_type) : 1;
      const bool is_face = is_corner_list(p);
      if (n_items < 0 || (is_face && n_items < 3))
        body.fail(fmt::format("a face has {} corners; allowed: 3 and more", show(n_items)));
      corners.clear();
      for (double k = 0; k < n_items; ++k) {
        const double item = body.next(p.type);
        if (!is_face) continue;
        if (!(item >= 0 && item <= 0xffffffffLL) || item != std::floor(item))
          body.fail(fmt::format("a face names vertex {}", show(item)));
        corners.push_back(static_cast<std::uint32_t>(item));
      }
      for (std::size_t k = 2; k < corners.size(); ++k)
        mesh.indices.insert(mesh.indices.end(), {corners[0], corners[k - 1], corners[k]});
    }
}

void skip_element(const PlyElement& element, Body& body) {
  for (std::uint64_t row = 0; row < element.count; ++row)
    for (const PlyProperty& p : element.properties) {
      const double n_items = p.is_list ? body.next(p.count_type) : 1;
      for (double k = 0; k < n_items; ++k) body.next(p.type);
    }
}

}  // namespace

}  // namespace myrialux
