// Numbers as people read them: durations, counts, bytes.
#pragma once

#include <cstdint>
#include <string>

namespace myrialux::app {

std::string duration_words(double seconds);          ///< "0.03 s", "12.4 s", "3 min 05 s", "2 h 07 min"
std::string count_words(double n);                   ///< "950", "12.3 k", "3.69 M", "40.1 G"
std::string bytes_words(std::uint64_t n_bytes);      ///< "812 MiB"
std::string absolute_path(const std::string& path);  ///< without . and ..

}  // namespace myrialux::app
