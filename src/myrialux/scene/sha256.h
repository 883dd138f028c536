// SHA-256 of a text [fips180].
#pragma once

#include <string>
#include <string_view>

namespace myrialux {

/// 64 hexadecimal digits.
std::string sha256(std::string_view text);

}  // namespace myrialux
