// SHA-256 [fips180, section 6.2]; no library that the project uses has it.
#include "myrialux/scene/sha256.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace myrialux {

namespace {

using Word = std::uint32_t;

/// First 32 bits of the fractional part of a root, found exactly in integers: root = floor(2^32 * p^(1/k)).
Word root_bits(std::uint64_t prime, int k) {
  using Wide = unsigned __int128;
  std::uint64_t low = 0, high = std::uint64_t{1} << 38;
  const auto is_above = [&](std::uint64_t x) {  // x^k > p * 2^(32 k)?
    if (k == 2) return Wide(x) * x > Wide(prime) << 64;
    const Wide square = Wide(x) * x;  // < 2^76; compare x * square with p * 2^96 without overflow
    const Wide high_part = (square >> 32) * x, low_part = (square & 0xffffffffu) * x;
    const Wide sum = high_part + (low_part >> 32);
    return sum > Wide(prime) << 64 || (sum == Wide(prime) << 64 && (low_part & 0xffffffffu) != 0);
  };
  while (high - low > 1) (is_above((low + high) / 2) ? high : low) = (low + high) / 2;
  return static_cast<Word>(low);
}

struct Constants {
  std::array<Word, 64> k;
  std::array<Word, 8> start;
  Constants() {
    int n = 0;
    for (std::uint64_t p = 2; n < 64; ++p) {
      bool is_prime = true;
      for (std::uint64_t d = 2; d * d <= p; ++d) is_prime = is_prime && p % d != 0;
      if (!is_prime) continue;
      if (n < 8) start[n] = root_bits(p, 2);
      k[n++] = root_bits(p, 3);
    }
  }
};

void add_block(const std::uint8_t* block, std::array<Word, 8>& state, const std::array<Word, 64>& k) {
  std::array<Word, 64> w;
  for (int t = 0; t < 16; ++t)
    w[t] = Word(block[4 * t]) << 24 | Word(block[4 * t + 1]) << 16 | Word(block[4 * t + 2]) << 8 | block[4 * t + 3];
  for (int t = 16; t < 64; ++t) {
    const Word a = w[t - 15], b = w[t - 2];
    w[t] = w[t - 16] + w[t - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ (a >> 3)) +
           (std::rotr(b, 17) ^ std::rotr(b, 19) ^ (b >> 10));
  }
  std::array<Word, 8> s = state;
  for (int t = 0; t < 64; ++t) {
    const Word sum1 = std::rotr(s[4], 6) ^ std::rotr(s[4], 11) ^ std::rotr(s[4], 25);
    const Word sum0 = std::rotr(s[0], 2) ^ std::rotr(s[0], 13) ^ std::rotr(s[0], 22);
    const Word t1 = s[7] + sum1 + ((s[4] & s[5]) ^ (~s[4] & s[6])) + k[t] + w[t];
    const Word t2 = sum0 + ((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
    s = {t1 + t2, s[0], s[1], s[2], s[3] + t1, s[4], s[5], s[6]};
  }
  for (int i = 0; i < 8; ++i) state[i] += s[i];
}

}  // namespace

std::string sha256(std::string_view text) {
  static const Constants constants;
  std::array<Word, 8> state = constants.start;
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  bytes.push_back(0x80);
  while (bytes.size() % 64 != 56) bytes.push_back(0);
  for (int shift = 56; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>((text.size() * 8) >> shift));
  for (std::size_t at = 0; at < bytes.size(); at += 64) add_block(bytes.data() + at, state, constants.k);
  std::string digits;
  for (const Word word : state) digits += fmt::format("{:08x}", word);
  return digits;
}

}  // namespace myrialux
