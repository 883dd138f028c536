#include "words.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace myrialux::app {

std::string duration_words(double seconds) {
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string count_words(double n) {
  const char* unit = "";
  for (const char* next : {" k", " M", " G", " T"}) {
    if (n < 999.5) break;
    n /= 1000, unit = next;
  }
  if (*unit == '\0') return fmt::format("{:.0f}", n);
  return fmt::format("{:.{}f}{}", n, n < 9.995 ? 2 : n < 99.95 ? 1 : 0, unit);
}

std::string bytes_words(std::uint64_t n_bytes) {
  const double mib = static_cast<double>(n_bytes) / (1 << 20);
  return mib < 1024 ? fmt::format("{:.0f} MiB", mib) : fmt::format("{:.2f} GiB", mib / 1024);
}

std::string absolute_path(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

}  // namespace myrialux::app
