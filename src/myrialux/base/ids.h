// Indices that cannot be swapped by mistake: each kind of thing has its own integer type.
#pragma once

#include <cstddef>
#include <cstdint>

namespace myrialux {

enum class ReceiverId : std::uint32_t {};  ///< row i of the light matrix
enum class LightId : std::uint32_t {};     ///< column j of the light matrix: a virtual light
enum class SliceId : std::uint32_t {};
enum class MeshId : std::uint32_t {};
enum class ShapeId : std::uint32_t {};
enum class MaterialId : std::uint32_t {};
enum class EmitterId : std::uint32_t {};
enum class TextureId : std::uint32_t {};

template <class Id>
inline constexpr Id kNone = static_cast<Id>(0xffffffffu);  ///< "no such thing"

template <class Id>
constexpr std::size_t index(Id id) {
  return static_cast<std::size_t>(id);
}

}  // namespace myrialux
