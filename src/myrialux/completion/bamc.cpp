// A column is copied from a traced one that agrees with its samples, or from the complement of one. [wang20, 4.5.1]
#include "myrialux/completion/bamc.h"

#include "myrialux/completion/column_basis.h"

namespace myrialux {
namespace {

class BooleanMatch final : public ColumnPredictor {
 public:
  void reset(std::size_t words_per_column) override { basis_.reset(words_per_column); }
  bool ready() const override { return !basis_.empty(); }
  void add(Words visible, Words known) override { basis_.add(visible, known); }
  bool predict(Words samples, Words omega, Rng& rng, MutableWords bits, MutableWords known) override {
    const std::vector<BasisMatch>& matches = basis_.find(samples, omega);
    if (matches.empty()) return false;
    const BasisMatch match = matches[rng.below(static_cast<std::uint32_t>(matches.size()))];
    const Words q = basis_.visible(match.column), known_q = basis_.known(match.column);
    const std::uint64_t turn = match.complemented ? ~std::uint64_t{0} : 0;
    for (std::size_t w = 0; w < bits.size(); ++w) {
      bits[w] = q[w] ^ turn;
      known[w] = known_q[w];
    }
    return true;
  }

 private:
  ColumnBasis basis_;  ///< Q
};

}  // namespace

CompletionStats complete_bamc(EntrySource& source, const BamcParams& params, Rng& rng, BitMatrix& visible) {
  BooleanMatch match;
  return complete_columns(source, params, "bamc", match, rng, visible);
}

CompletionStats trace_all(EntrySource& source, BitMatrix& visible) {
  CompletionStats stats;
  for (std::size_t j = 0; j < source.n_columns(); ++j) {
    const Words active = source.active(j);
    const std::size_t n = count_bits(active);
    if (n == 0) continue;
    source.trace(j, active, visible.column(j));
    stats.entries += n;
    stats.traced += n;
    ++stats.full_columns;
  }
  return stats;
}

}  // namespace myrialux
