// Reading numbers and names out of text, and naming the place of an offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "myrialux/base/error.h"

namespace myrialux {

/// A whole number or decimal that fills `text` apart from blanks; nothing for anything else, infinities and NaN
/// included.
std::optional<double> parse_number(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);
/// Numbers apart from each other by blanks or commas.
std::optional<std::vector<double>> parse_numbers(std::string_view text);
std::string_view trim(std::string_view text);
/// Words between blanks.
std::vector<std::string_view> split_words(std::string_view text);
/// A number as messages show it: shortest form of single precision.
std::string show(double value);

/// Line and column of an offset into a text; built once a file.
class LineTable {
 public:
  LineTable(std::string file, std::string_view text);
  TextPosition at(std::size_t offset) const;

 private:
  std::string file_;
  std::vector<std::size_t> starts_;
};

/// Whole file as bytes; nothing if it cannot be read.
std::optional<std::string> read_file(const std::string& path);

}  // namespace myrialux
