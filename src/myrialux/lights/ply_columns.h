// Columns of virtual lights in a PLY file, one table for writer and reader. Described in docs/formats.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace myrialux {

enum class PlyColumn : std::uint8_t {
  x,
  y,
  z,
  nx,
  ny,
  nz,
  r,
  g,
  b,  // what every file has
  bounce,
  kind,
  ngx,
  ngy,
  ngz,
  offset,  // ours
  bsdf,
  wix,
  wiy,
  wiz,
  alpha,
  diffuse_r,
  diffuse_g,
  diffuse_b,  // where glossy lights are
  specular_r,
  specular_g,
  specular_b,
  cos_cutoff,
  cos_beam,  // where spots are
  count
};
inline constexpr std::size_t kPlyColumns = static_cast<std::size_t>(PlyColumn::count);
inline constexpr std::array<const char*, kPlyColumns> kPlyNames = {
    "x",         "y",         "z",          "nx",         "ny",         "nz",         "r",
    "g",         "b",         "bounce",     "kind",       "ngx",        "ngy",        "ngz",
    "offset",    "bsdf",      "wix",        "wiy",        "wiz",        "alpha",      "diffuse_r",
    "diffuse_g", "diffuse_b", "specular_r", "specular_g", "specular_b", "cos_cutoff", "cos_beam"};
inline constexpr PlyColumn kFirstOwn = PlyColumn::bounce, kFirstGlossy = PlyColumn::bsdf,
                           kFirstSpot = PlyColumn::cos_cutoff;
inline constexpr const char* kPlySignature = "myrialux virtual lights 1";
inline constexpr float kNoSpot = -2;  ///< cos_cutoff of a point light that shines everywhere

inline constexpr const char* ply_type(PlyColumn c) {
  return c == PlyColumn::bounce || c == PlyColumn::kind ? "uchar" : c == PlyColumn::bsdf ? "int" : "float";
}

}  // namespace myrialux
