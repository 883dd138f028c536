// Reads Wavefront OBJ: v, vt, vn, f with positive or negative indices; polygons become fans of triangles.
#include "myrialux/scene/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include "myrialux/scene/mesh.h"
#include "myrialux/scene/text.h"

namespace myrialux {

namespace {

constexpr std::size_t kMaxMistakes = 20;  ///< a file: the rest is most likely of the same kind

struct Corner {
  std::int32_t v = -1, vt = -1, vn = -1;
};
/// A vertex made from a corner, chained with the others at the same position.
struct MadeVertex {
  std::int32_t vt, vn;
  std::uint32_t part, index;
  std::int32_t next;
};
struct Broken {
  std::string what;
};

class Parser {
 public:
  Parser(const std::string& path, bool by_material) : path_(path), by_material_(by_material) {}
  ObjFile parse(std::string_view text, Diagnostics& found);

 private:
  void parse_line(std::string_view line);
  void parse_face(std::string_view rest);
  void use_material(const std::string& name);
  std::uint32_t vertex_of(const Corner& corner);
  void drop_absent_fields();

  const std::string& path_;
  bool by_material_;
  ObjFile file_;
  std::uint32_t part_ = 0;
  std::vector<Vec3> positions_, normals_;
  std::vector<Vec2> uvs_;
  std::vector<MadeVertex> made_;
  std::vector<std::int32_t> first_made_;  ///< [n_positions] into made_, -1 = none
  std::vector<Corner> corners_;
  std::uint32_t line_ = 0;
};

}  // namespace

ObjFile read_obj_file(const std::string& path, bool by_material, Diagnostics& found) {
  const std::optional<std::string> text = read_file(path);
  if (!text) return found.error({path, 0, 0}, "cannot be read"), ObjFile{};
  return Parser(path, by_material).parse(*text, found);
}

Mesh read_obj(const std::string& path, Diagnostics& found) {
  ObjFile file = read_obj_file(path, false, found);
  return file.parts.empty() ? Mesh{} : std::move(file.parts.front().mesh);
}

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view next_word(std::string_view& rest) {
  std::size_t start = 0;
  while (start < rest.size() && is_blank(rest[start])) ++start;
  std::size_t end = start;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(start, end - start);
  rest.remove_prefix(end);
  return word;
}

float next_number(std::string_view& rest, const char* what) {
  std::string_view word = next_word(rest);
  if (word.starts_with('+')) word.remove_prefix(1);
  float value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty()) throw Broken{fmt::format("{} has too few numbers", what)};
  if (code == std::errc::result_out_of_range && std::abs(parse_number(word).value_or(1)) < 1) return 0;
  if (code != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
    throw Broken{fmt::format("{}: \"{}\" is not a finite number", what, std::string(word.substr(0, 40)))};
  return value;
}

/// One index of a corner, from 0; counted from the end if negative. Takes it off `word`.
std::int32_t next_index(std::string_view& word, std::size_t n, const char* what) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc{}) throw Broken{fmt::format("face: \"{}\" is not an index", std::string(word.substr(0, 40)))};
  word.remove_prefix(static_cast<std::size_t>(end - word.data()));
  const std::int64_t count = static_cast<std::int64_t>(n), from_zero = value > 0 ? value - 1 : count + value;
  if (value == 0 || from_zero < 0 || from_zero >= count)
    throw Broken{fmt::format("face names {} {}, but {} are known so far; allowed: 1 to {}, or -1 to -{}", what, value,
                             count, count, count)};
  return static_cast<std::int32_t>(from_zero);
}

ObjFile Parser::parse(std::string_view text, Diagnostics& found) {
  if (!by_material_) file_.parts.emplace_back();
  std::size_t n_mistakes = 0;
  std::string joined;  // lines that end in a backslash go on in the next one
  for (std::size_t at = 0; at < text.size();) {
    const void* end_of_line = std::memchr(text.data() + at, '\n', text.size() - at);
    const std::size_t end = end_of_line ? static_cast<const char*>(end_of_line) - text.data() : text.size();
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++line_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.ends_with('\\')) {
      joined.append(line.substr(0, line.size() - 1)) += ' ';
      continue;
    }
    if (!joined.empty()) line = joined.append(line);
    try {
      parse_line(line);
    } catch (const Broken& broken) {
      found.error({path_, line_, 0}, broken.what);
      if (++n_mistakes == kMaxMistakes) break;
    }
    joined.clear();
  }
  drop_absent_fields();
  return std::move(file_);
}

void Parser::parse_line(std::string_view line) {
  const std::string_view key = next_word(line);
  if (key.empty() || key.front() == '#') return;
  if (key == "v") {
    const float x = next_number(line, "v"), y = next_number(line, "v"), z = next_number(line, "v");
    if (positions_.size() >= 0x7ffffff0) throw Broken{"more than 2^31 vertices"};
    positions_.push_back({x, y, z});
    first_made_.push_back(-1);
  } else if (key == "vt") {
    const float u = next_number(line, "vt");
    uvs_.push_back({u, trim(line).empty() ? 0 : next_number(line, "vt")});
  } else if (key == "vn") {
    const float x = next_number(line, "vn"), y = next_number(line, "vn"), z = next_number(line, "vn");
    normals_.push_back({x, y, z});
  } else if (key == "f") {
    parse_face(line);
  } else if (key == "usemtl") {
    use_material(std::string(trim(line)));
  } else if (key == "mtllib") {
    file_.material_files.emplace_back(std::string(trim(line)), TextPosition{path_, line_, 0});
  } else if (key.size() > 20 ||
             !std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isalnum(c) || c == '_'; })) {
    throw Broken{fmt::format("not an OBJ line: \"{}\"", std::string(key.substr(0, 40)))};
  }  // groups, smoothing, lines, points, curves: of no use here
}

void Parser::use_material(const std::string& name) {
  if (!by_material_) return;
  for (part_ = 0; part_ < file_.parts.size(); ++part_)
    if (file_.parts[part_].material == name) return;
  file_.parts.push_back({name, {path_, line_, 0}, {}});
}

void Parser::parse_face(std::string_view rest) {
  corners_.clear();
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    Corner corner;
    corner.v = next_index(word, positions_.size(), "vertex");
    if (word.starts_with('/')) {
      word.remove_prefix(1);
      if (!word.empty() && word.front() != '/') corner.vt = next_index(word, uvs_.size(), "texture vertex");
    }
    if (word.starts_with('/')) {
      word.remove_prefix(1);
      if (!word.empty()) corner.vn = next_index(word, normals_.size(), "normal");
    }
    if (!word.empty()) throw Broken{fmt::format("face: \"{}\" is left over after a corner", std::string(word))};
    corners_.push_back(corner);
  }
  if (corners_.size() < 3) throw Broken{fmt::format("face has {} corners; allowed: 3 and more", corners_.size())};
  if (part_ >= file_.parts.size()) use_material("");
  std::uint32_t first = 0, previous = 0;
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const std::uint32_t v = vertex_of(corners_[k]);
    std::vector<std::uint32_t>& indices = file_.parts[part_].mesh.indices;
    if (k == 0) first = v;
    if (k >= 2) indices.insert(indices.end(), {first, previous, v});
    previous = v;
  }
}

std::uint32_t Parser::vertex_of(const Corner& corner) {
  for (std::int32_t m = first_made_[corner.v]; m >= 0; m = made_[m].next)
    if (made_[m].vt == corner.vt && made_[m].vn == corner.vn && made_[m].part == part_) return made_[m].index;
  Mesh& mesh = file_.parts[part_].mesh;
  const std::uint32_t v = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(positions_[corner.v]);
  mesh.uvs.push_back(corner.vt >= 0 ? uvs_[corner.vt] : Vec2{});
  mesh.normals.push_back(corner.vn >= 0 ? normals_[corner.vn] : Vec3{});  // 0: made later from the triangles
  made_.push_back({corner.vt, corner.vn, part_, v, first_made_[corner.v]});
  first_made_[corner.v] = static_cast<std::int32_t>(made_.size()) - 1;
  return v;
}

/// Parts without any normal or texture coordinate lose the array.
void Parser::drop_absent_fields() {
  std::vector<bool> has_uvs(file_.parts.size()), has_normals(file_.parts.size());
  for (const MadeVertex& m : made_) {
    if (m.vt >= 0) has_uvs[m.part] = true;
    if (m.vn >= 0) has_normals[m.part] = true;
  }
  for (std::size_t p = 0; p < file_.parts.size(); ++p) {
    if (!has_uvs[p]) file_.parts[p].mesh.uvs.clear();
    if (!has_normals[p]) file_.parts[p].mesh.normals.clear();
  }
}

}  // namespace

}  // namespace myrialux
