// Names, sizes and bytes of the number types of PLY files.
#include "myrialux/scene/ply_format.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

namespace myrialux {

std::optional<PlyType> parse_ply_type(std::string_view word) {
  using enum PlyType;
  static const std::map<std::string_view, PlyType> types = {
      {"char", i8},    {"int8", i8},     {"uchar", u8},   {"uint8", u8},   {"short", i16}, {"int16", i16},
      {"ushort", u16}, {"uint16", u16},  {"int", i32},    {"int32", i32},  {"uint", u32},  {"uint32", u32},
      {"float", f32},  {"float32", f32}, {"double", f64}, {"float64", f64}};
  const auto found = types.find(word);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

std::size_t size_of(PlyType type) {
  constexpr std::array<std::size_t, 8> sizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

namespace {

template <class T>
double load(const char* bytes, bool swap) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return static_cast<double>(value);
}

}  // namespace

double load_number(const char* bytes, PlyType type, bool swap) {
  switch (type) {
    case PlyType::i8:
      return load<std::int8_t>(bytes, swap);
    case PlyType::u8:
      return load<std::uint8_t>(bytes, swap);
    case PlyType::i16:
      return load<std::int16_t>(bytes, swap);
    case PlyType::u16:
      return load<std::uint16_t>(bytes, swap);
    case PlyType::i32:
      return load<std::int32_t>(bytes, swap);
    case PlyType::u32:
      return load<std::uint32_t>(bytes, swap);
    case PlyType::f32:
      return load<float>(bytes, swap);
    case PlyType::f64:
      break;
  }
  return load<double>(bytes, swap);
}

}  // namespace myrialux
