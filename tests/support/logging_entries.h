// A known matrix that remembers what was asked of it, in order.
#pragma once

#include <vector>

#include "myrialux/matrix/known_entries.h"

namespace myrialux::test {

class LoggingEntries : public KnownEntries {
 public:
  using KnownEntries::KnownEntries;
  explicit LoggingEntries(const KnownEntries& known) : KnownEntries(known) {}
  struct Call {
    std::size_t column;
    std::vector<std::uint64_t> wanted;
    std::size_t n_wanted() const { return count_bits(wanted); }
  };
  std::vector<Call> calls;
  std::size_t n_asked_twice = 0, n_asked_inactive = 0;

  void trace(std::size_t j, Words wanted, MutableWords visible) override {
    const MutableWords asked = asked_.column(j);
    for (std::size_t w = 0; w < wanted.size(); ++w) {
      n_asked_twice += static_cast<std::size_t>(std::popcount(wanted[w] & asked[w]));
      n_asked_inactive += static_cast<std::size_t>(std::popcount(wanted[w] & ~active(j)[w]));
      asked[w] |= wanted[w];
    }
    calls.push_back({j, {wanted.begin(), wanted.end()}});
    KnownEntries::trace(j, wanted, visible);
  }
  const BitMatrix& asked() const { return asked_; }
  std::vector<Call> calls_of(std::size_t column) const {
    std::vector<Call> found;
    for (const Call& c : calls)
      if (c.column == column) found.push_back(c);
    return found;
  }

 private:
  BitMatrix asked_{n_rows(), n_columns()};
};

}  // namespace myrialux::test
