// Writes virtual lights as a PLY point cloud; layout in docs/formats.md.
#include <bit>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "myrialux/lights/ply_columns.h"
#include "myrialux/lights/virtual_lights.h"

namespace myrialux {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they lie in memory");

/// Materials that glossy lights use, in order of first use: the header's comment table.
struct MaterialTable {
  std::vector<MaterialId> used;
  std::map<MaterialId, int> entry;
  explicit MaterialTable(const VirtualLights& lights) {
    for (const auto& g : lights.glossy)
      if (entry.emplace(g.bsdf.material, static_cast<int>(used.size())).second) used.push_back(g.bsdf.material);
  }
};
std::vector<PlyColumn> columns_of(const VirtualLights& lights);
std::string header(const VirtualLights& lights, const Scene& scene, const MaterialTable& table,
                   const std::vector<PlyColumn>& columns, bool binary);
float value(const VirtualLights& lights, std::size_t j, PlyColumn column, const MaterialTable& table);
void append_binary(std::string& out, PlyColumn column, float v);
void append_text(std::string& out, PlyColumn column, float v);

}  // namespace

void write_lights(const VirtualLights& lights, const Scene& scene, const std::string& path, bool binary) {
  const std::string unfinished = path + ".part";  // renamed when whole
  const auto fail = [&](const std::string& why) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    throw Error(ErrorKind::output, path + ": cannot write virtual lights: " + why +
                                       "; check that the folder exists, is writable and has room");
  };
  std::ofstream file(unfinished, std::ios::binary);
  if (!file) fail(std::strerror(errno));

  const MaterialTable table(lights);
  const std::vector<PlyColumn> columns = columns_of(lights);
  file << header(lights, scene, table, columns, binary);
  std::string text;
  for (std::size_t j = 0; j < lights.size(); ++j) {
    for (const PlyColumn c : columns) (binary ? append_binary : append_text)(text, c, value(lights, j, c, table));
    if (!binary) text.back() = '\n';
    if (text.size() < (1u << 16) && j + 1 < lights.size()) continue;
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    text.clear();
  }
  file.close();
  if (!file) fail("the write did not complete");
  std::error_code error;
  std::filesystem::rename(unfinished, path, error);
  if (error) fail(error.message());
}

namespace {

std::vector<PlyColumn> columns_of(const VirtualLights& lights) {
  std::vector<PlyColumn> columns;
  for (std::size_t c = 0; c < kPlyColumns; ++c) {
    const auto column = static_cast<PlyColumn>(c);
    if (column >= kFirstSpot ? lights.spots.empty() : column >= kFirstGlossy && lights.glossy.empty()) continue;
    columns.push_back(column);
  }
  return columns;
}

std::string header(const VirtualLights& lights, const Scene& scene, const MaterialTable& table,
                   const std::vector<PlyColumn>& columns, bool binary) {
  std::string text = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") + " 1.0\ncomment " +
                     kPlySignature + "\n";
  for (std::size_t k = 0; k < table.used.size(); ++k) {
    std::string name = scene.materials[index(table.used[k])].name;
    for (char& c : name)
      if (c == '\n' || c == '\r') c = ' ';
    text += "comment bsdf " + std::to_string(k) + " " + std::to_string(index(table.used[k])) + " " + name + "\n";
  }
  text += "element vertex " + std::to_string(lights.size()) + "\n";
  for (const PlyColumn c : columns)
    text += std::string("property ") + ply_type(c) + " " + kPlyNames[static_cast<std::size_t>(c)] + "\n";
  return text + "end_header\n";
}

float of(Vec3 v, PlyColumn column, PlyColumn first) { return v[static_cast<int>(column) - static_cast<int>(first)]; }
float of(Rgb v, PlyColumn column, PlyColumn first) { return of(Vec3{v.r, v.g, v.b}, column, first); }

float value(const VirtualLights& lights, std::size_t j, PlyColumn column, const MaterialTable& table) {
  using C = PlyColumn;
  if (column <= C::z) return of(lights.p[j], column, C::x);
  if (column <= C::nz) return of(lights.n[j], column, C::nx);
  if (column <= C::b) return of(lights.light[j], column, C::r);
  if (column == C::bounce) return lights.bounce[j];
  if (column == C::kind) return static_cast<float>(lights.kind[j]);
  if (column <= C::ngz) return of(lights.ng[j], column, C::ngx);
  if (column == C::offset) return lights.offset[j];
  const std::uint32_t extra = lights.extra[j];
  if (column >= kFirstSpot) {
    const bool spot = lights.kind[j] == LightKind::point && extra < lights.spots.size();
    if (column == C::cos_cutoff) return spot ? lights.spots[extra].cos_cutoff : kNoSpot;
    return spot ? lights.spots[extra].cos_beam : kNoSpot;
  }
  if (lights.kind[j] != LightKind::glossy) return column == C::bsdf ? -1.0f : 0.0f;
  const VirtualLights::Glossy& g = lights.glossy[extra];
  if (column == C::bsdf) return static_cast<float>(table.entry.at(g.bsdf.material));
  if (column <= C::wiz) return of(g.wi, column, C::wix);
  if (column == C::alpha) return g.bsdf.alpha;
  if (column <= C::diffuse_b) return of(g.bsdf.reflectance, column, C::diffuse_r);
  return of(g.bsdf.specular, column, C::specular_r);
}

template <class T>
void append_bytes(std::string& out, T v) {
  out.append(reinterpret_cast<const char*>(&v), sizeof v);
}

void append_binary(std::string& out, PlyColumn column, float v) {
  if (column == PlyColumn::bounce || column == PlyColumn::kind) return append_bytes(out, static_cast<std::uint8_t>(v));
  if (column == PlyColumn::bsdf) return append_bytes(out, static_cast<std::int32_t>(v));
  append_bytes(out, v);
}

/// Shortest text that reads back as the same number, and a blank.
void append_text(std::string& out, PlyColumn, float v) {
  char buffer[32];
  out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, v).ptr);
  out += ' ';
}

}  // namespace
}  // namespace myrialux
