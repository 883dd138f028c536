// Number types of Stanford PLY files, for the readers of meshes and of virtual lights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace myrialux {

enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Type of either spelling ("float", "float32"); nothing for any other word.
std::optional<PlyType> parse_ply_type(std::string_view word);
std::size_t size_of(PlyType type);  ///< bytes
/// The number at `bytes`; `swap` for files of the other byte order.
double load_number(const char* bytes, PlyType type, bool swap);

}  // namespace myrialux
