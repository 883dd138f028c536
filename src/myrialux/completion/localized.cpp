// One column after the other; what is known of the column at hand lies in bit masks of rows and of blocks.
#include "myrialux/completion/localized.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/completion/block_masks.h"
#include "myrialux/completion/block_neighbours.h"
#include "myrialux/completion/remembered_columns.h"
#include "myrialux/kernels/above.h"

namespace myrialux {
namespace {

/// Columns that the running mean of contradictions looks back on.
constexpr float kColumnsLookedBack = 64;

/// Least doubt: what happens in a slice has not been seen often enough to say less.
constexpr float kLeastDoubt = 1e-3f;

/// What the doubt counts in columns that their first samples settled, where `risk` is weighed: less than their share of
/// wrong bits, as chosen by speed and error of whole pictures.
constexpr float kSettledDoubt = 0.01f;

/// Shares of wrong bits among those not traced, for BlockDoubts (measured; docs/methods/lbamc.md): of predicted mixed
/// blocks, of those traced in some rows, and of uniform blocks over the doubt, with a sample and without, times the
/// last in settled columns.
constexpr float kMixedShare = 0.1f, kPartlyShare = 0.1f, kSampledShare = 0.4f, kUnsampledShare = 0.65f,
                kSettledShare = 0.1f;

/// The 16 rows of a block.
std::uint32_t block_of(Words rows, std::size_t b) {
  return static_cast<std::uint32_t>(rows[b / kBlocksInWord] >> b % kBlocksInWord * kRowsInBlock & 0xffff);
}

class LocalizedCompletion {
 public:
  LocalizedCompletion(EntrySource& source, const LocalizedParams& params, Rng& rng, BitMatrix& visible,
                      BlockDoubts* doubts);
  CompletionStats run();

 private:
  using Kind = RememberedColumns::Kind;

  void complete_column();
  void trace_whole();
  void repair(std::size_t predictor, bool settled);
  bool copy_uniform(std::size_t q);
  float largest_copied(bool settled) const;
  float share_of_copied(std::size_t b, bool settled) const;
  void want_quads(std::size_t b);
  std::uint32_t fill_quads(std::size_t b) const;
  void list_active_blocks();
  void want_block(std::size_t b);
  void want_row(std::size_t b);
  void choose_rows(std::size_t count);
  void sample(std::size_t count, float great);
  void trace_wanted();
  bool samples_agree() const;
  void predict(std::size_t q);
  void update_doubt();
  void trace_doubtful_blocks(bool settled);
  void find_changed_blocks();
  void spread_doubt();
  void copy_others();
  void note_doubts(bool settled);
  void note_uniform_doubts();
  Kind kind_of_column() const;

  EntrySource& source_;
  const LocalizedParams params_;
  BitMatrix& visible_;
  BlockDoubts* const doubts_;  ///< null: not asked for
  const std::size_t words_, n_blocks_;
  const BlockNeighbours neighbours_;
  RememberedColumns remembered_;
  std::uint32_t turn_;  ///< turns samples over the rows, on and on from column to column
  float doubt_ = 0;     ///< running mean of the share of samples that contradict
  CompletionStats stats_;

  // Of the column at hand.
  std::size_t j_ = 0, n_active_ = 0;
  Words active_;
  MutableWords column_;
  std::vector<std::uint64_t> traced_, wanted_;  ///< rows
  std::vector<std::uint64_t> predicted_;        ///< bits of all rows
  std::vector<std::uint32_t> active_blocks_;    ///< those with active rows, ascending
  std::vector<float> energies_;                 ///< by block
  BlockMask active_mask_;                       ///< active_blocks_ as a mask
  BlockMask sampled_;                           ///< blocks with a row that is wanted or traced
  BlockMask bright_;                            ///< blocks above the energy that is asked about
  BlockMask sees_, misses_;                     ///< blocks predicted to have visible, occluded rows; both: mixed
  BlockMask whole_;                             ///< blocks that are traced in all rows, if at all
  BlockMask doubtful_, done_, changed_;         ///< to be traced next; traced; traced and not in the state predicted
};

LocalizedCompletion::LocalizedCompletion(EntrySource& source, const LocalizedParams& params, Rng& rng,
                                         BitMatrix& visible, BlockDoubts* doubts)
    : source_(source),
      params_(params),
      visible_(visible),
      doubts_(doubts),
      words_(visible.words_per_column()),
      n_blocks_(words_ * kBlocksInWord),
      neighbours_(source, n_blocks_, std::min<std::size_t>(params.flood, n_blocks_ - 1)),
      remembered_(params.memory, words_),
      turn_(rng.next_uint()),
      traced_(words_),
      wanted_(words_),
      predicted_(words_),
      energies_(n_blocks_),
      active_mask_(n_blocks_),
      sampled_(n_blocks_),
      bright_(n_blocks_),
      sees_(n_blocks_),
      misses_(n_blocks_),
      whole_(n_blocks_),
      doubtful_(n_blocks_),
      done_(n_blocks_),
      changed_(n_blocks_) {
  active_blocks_.reserve(n_blocks_);
}

CompletionStats LocalizedCompletion::run() {
  for (j_ = 0; j_ < source_.n_columns(); ++j_) {
    active_ = source_.active(j_);
    column_ = visible_.column(j_);
    n_active_ = count_bits(active_);
    stats_.entries += n_active_;
    if (n_active_ > 0) complete_column();
  }
  return stats_;
}

void LocalizedCompletion::complete_column() {
  std::fill(traced_.begin(), traced_.end(), 0);
  list_active_blocks();
  if (n_active_ <= params_.few || remembered_.empty()) return trace_whole();

  // A few rows tell which column this one is like; where all is of one kind, they are enough.
  source_.block_energies(j_, energies_);
  const Words required = source_.required(j_);
  std::copy(required.begin(), required.end(), wanted_.begin());
  above(energies_, params_.guard, bright_.words());
  for_each_bit(bright_.words(), [&](std::size_t b) {
    if (active_mask_.test(b)) want_block(b);
  });
  sample(params_.first_samples, params_.settle);
  NearestColumn nearest = remembered_.nearest(column_, traced_);
  const bool settled = nearest.distance == 0 && samples_agree() &&
                       remembered_.kind(nearest.column) == (count_bits(column_) > 0 ? Kind::visible : Kind::occluded);
  if (!settled) {
    sample(params_.samples - std::min(params_.samples, params_.first_samples), params_.watch);
    nearest = remembered_.nearest(column_, traced_);
  }
  repair(nearest.column, settled);
}

/// Blocks are copied where nothing speaks against it.
void LocalizedCompletion::repair(std::size_t predictor, bool settled) {
  if (settled && copy_uniform(predictor)) return;
  predict(predictor);
  update_doubt();
  trace_doubtful_blocks(settled);
  if (doubts_) note_doubts(settled);
  copy_others();
  remembered_.add(column_, active_, active_mask_.words(), kind_of_column());
}

/// Copies a uniform column, unless it does not know all blocks or some are worth too much. Returns whether it did.
bool LocalizedCompletion::copy_uniform(std::size_t q) {
  above(energies_, largest_copied(true), bright_.words());
  const Words known = remembered_.blocks(q);
  for (std::size_t word = 0; word < bright_.n_words(); ++word)
    if ((active_mask_[word] & (bright_[word] | ~known[word])) != 0) return false;
  const Kind kind = remembered_.kind(q);
  if (kind == Kind::visible) std::copy(active_.begin(), active_.end(), column_.begin());
  if (doubts_) note_uniform_doubts();
  doubt_ -= doubt_ / kColumnsLookedBack;
  remembered_.add(column_, active_, active_mask_.words(), kind);
  return true;
}

/// Energy above which a uniform block is not copied.
float LocalizedCompletion::largest_copied(bool settled) const {
  return std::sqrt(params_.risk / (std::max(doubt_, kLeastDoubt) * (settled ? kSettledDoubt : 1.0f)));
}

void LocalizedCompletion::trace_whole() {
  std::copy(active_.begin(), active_.end(), wanted_.begin());
  trace_wanted();
  ++stats_.full_columns;
  remembered_.add(column_, active_, active_mask_.words(), kind_of_column());
}

RememberedColumns::Kind LocalizedCompletion::kind_of_column() const {
  const std::size_t n_visible = count_bits(column_);
  return n_visible == 0 ? Kind::occluded : n_visible == n_active_ ? Kind::visible : Kind::mixed;
}

/// The share of samples in blocks predicted uniform that contradict them enters the running mean.
void LocalizedCompletion::update_doubt() {
  std::size_t n_tested = 0, n_contradict = 0;
  for (std::size_t w = 0; w < words_; ++w) {
    if (traced_[w] == 0) continue;
    const std::uint64_t tested = traced_[w] & rows_of_blocks(sees_.four(w) ^ misses_.four(w));
    n_tested += static_cast<std::size_t>(std::popcount(tested));
    n_contradict += static_cast<std::size_t>(std::popcount((predicted_[w] ^ column_[w]) & tested));
  }
  if (n_tested == 0) return;
  const float share = static_cast<float>(n_contradict) / static_cast<float>(n_tested);
  doubt_ += (share - doubt_) / kColumnsLookedBack;
}

void LocalizedCompletion::list_active_blocks() {
  active_mask_.clear();
  sampled_.clear();
  for (std::size_t w = 0; w < words_; ++w) active_mask_.add_four(w, any_in_blocks(active_[w]));
  active_blocks_.clear();
  for_each_bit(active_mask_.words(), [&](std::size_t b) { active_blocks_.push_back(static_cast<std::uint32_t>(b)); });
}

/// All active rows of a block.
void LocalizedCompletion::want_block(std::size_t b) {
  const std::size_t word = b / kBlocksInWord;
  wanted_[word] |= active_[word] & rows_of_blocks(std::uint64_t{1} << b % kBlocksInWord);
  sampled_.set(b);
}

/// Wants one active row of a block.
void LocalizedCompletion::want_row(std::size_t b) {
  const std::uint32_t rows = block_of(active_, b);
  const auto from = ((turn_ >> 20) + 7 * static_cast<std::uint32_t>(b)) % kRowsInBlock;
  const std::uint32_t turned = (rows | rows << kRowsInBlock) >> from;  // the first active row from there on, in a ring
  const std::uint32_t row = (static_cast<std::uint32_t>(std::countr_zero(turned)) + from) % kRowsInBlock;
  wanted_[b / kBlocksInWord] |= std::uint64_t{1} << (b % kBlocksInWord * kRowsInBlock + row);
  sampled_.set(b);
}

/// Wants one row in each of `count` active blocks (as many as there are), evenly spaced. Which blocks, and which of
/// their rows, goes on turning.
void LocalizedCompletion::choose_rows(std::size_t count) {
  const std::uint64_t n = active_blocks_.size(), n_taken = std::min<std::uint64_t>(count, n);
  if (n_taken == 0) return;
  turn_ += 0x9e3779b9u;  // steps of the golden ratio: every stretch of turns is spread evenly
  const std::uint64_t step = (n << 32) / n_taken;
  std::uint64_t place = turn_ * n;  // in the list, 32 bits after the point
  for (std::uint64_t k = 0; k < n_taken; ++k, place += step) {
    if (place >= n << 32) place -= n << 32;
    want_row(active_blocks_[place >> 32]);
  }
}

/// Traces some rows, and one in each block of great energy that has none yet, besides what is wanted already.
void LocalizedCompletion::sample(std::size_t count, float great) {
  choose_rows(count);
  above(energies_, great, bright_.words());
  for (std::size_t word = 0; word < bright_.n_words(); ++word) bright_[word] &= active_mask_[word] & ~sampled_[word];
  for_each_bit(bright_.words(), [&](std::size_t b) { want_row(b); });
  for (std::size_t w = 0; w < words_; ++w) wanted_[w] &= ~traced_[w];
  trace_wanted();
}

/// Traces wanted rows, none of which is traced yet, and forgets what was wanted.
void LocalizedCompletion::trace_wanted() {
  const std::size_t n = count_bits(wanted_);
  if (n == 0) return;
  stats_.traced += n;
  source_.trace(j_, wanted_, column_);
  for (std::size_t w = 0; w < words_; ++w) {
    MYRIALUX_ASSERT((traced_[w] & wanted_[w]) == 0);  // no entry is asked for twice
    traced_[w] |= wanted_[w];
    wanted_[w] = 0;
  }
}

/// All traced rows are visible, or none is.
bool LocalizedCompletion::samples_agree() const {
  const std::size_t n_visible = count_bits(column_);
  return n_visible == 0 || n_visible == count_bits(traced_);
}

/// Reads a remembered column block by block; uniform blocks speak for all their rows.
void LocalizedCompletion::predict(std::size_t q) {
  const Words visible = remembered_.visible(q), known = remembered_.known(q);
  sees_.clear();
  misses_.clear();
  for (std::size_t w = 0; w < words_; ++w) {
    const std::uint64_t sees = any_in_blocks(visible[w] & known[w]), misses = any_in_blocks(known[w] & ~visible[w]);
    sees_.add_four(w, sees);
    misses_.add_four(w, misses);
    predicted_[w] = (visible[w] & known[w] & rows_of_blocks(sees & misses)) | rows_of_blocks(sees & ~misses);
  }
}

/// Traces blocks as long as one turns out not to be as predicted.
void LocalizedCompletion::trace_doubtful_blocks(bool settled) {
  above(energies_, params_.copy_mixed, bright_.words());
  above(energies_, params_.whole, whole_.words());
  above(energies_, largest_copied(settled), doubtful_.words());  // too much to be copied
  done_.clear();
  for (std::size_t w = 0; w < words_; ++w) {
    const std::uint64_t sees = sees_.four(w), misses = misses_.four(w), mixed = sees & misses;
    const std::uint64_t contradicted = any_in_blocks((predicted_[w] ^ column_[w]) & traced_[w]);
    doubtful_.add_four(w, contradicted | (~(sees | misses) & 15) | (mixed & bright_.four(w)));
  }
  for (std::size_t word = 0; word < done_.n_words(); ++word) doubtful_[word] &= active_mask_[word];
  while (!doubtful_.empty()) {
    for (std::size_t w = 0; w < words_; ++w)
      wanted_[w] = rows_of_blocks(doubtful_.four(w) & whole_.four(w)) & active_[w] & ~traced_[w];
    for_each_bit(doubtful_.words(), [&](std::size_t b) {
      if (!whole_.test(b)) want_quads(b);
    });
    trace_wanted();
    find_changed_blocks();
    spread_doubt();
  }
}

/// Of the doubtful blocks, now looked at, those that are not in the state predicted; of those of which only some rows
/// are traced, the ones that contradict.
void LocalizedCompletion::find_changed_blocks() {
  changed_.clear();
  for (std::size_t w = 0; w < words_; ++w) {
    const std::uint64_t doubtful = doubtful_.four(w);
    if (doubtful == 0) continue;
    const std::uint64_t sees = any_in_blocks(column_[w]), misses = any_in_blocks(traced_[w] & ~column_[w]);
    const std::uint64_t was_known = sees_.four(w) | misses_.four(w);
    const std::uint64_t differs = (sees ^ sees_.four(w)) | (misses ^ misses_.four(w));
    const std::uint64_t contradicts = any_in_blocks((predicted_[w] ^ column_[w]) & traced_[w]);
    const std::uint64_t whole = ~any_in_blocks(active_[w] & ~traced_[w]);
    changed_.add_four(w, ((differs & whole) | (contradicts & ~whole)) & was_known & doubtful);
  }
}

/// Doubtful blocks are done; the neighbours of changed ones become doubtful.
void LocalizedCompletion::spread_doubt() {
  for (std::size_t word = 0; word < done_.n_words(); ++word) done_[word] |= doubtful_[word];
  doubtful_.clear();
  for_each_bit(changed_.words(), [&](std::size_t b) {
    const Words near = neighbours_.of(b);
    for (std::size_t word = 0; word < near.size(); ++word) doubtful_[word] |= near[word];
  });
  for (std::size_t word = 0; word < done_.n_words(); ++word) doubtful_[word] &= active_mask_[word] & ~done_[word];
}

float LocalizedCompletion::share_of_copied(std::size_t b, bool settled) const {
  const float share = block_of(traced_, b) != 0 ? kSampledShare : kUnsampledShare;
  return share * std::max(doubt_, kLeastDoubt) * (settled ? kSettledShare : 1.0f);
}

/// After blocks are traced, before others are copied.
void LocalizedCompletion::note_doubts(bool settled) {
  for (const std::uint32_t b : active_blocks_) {
    if ((block_of(active_, b) & ~block_of(traced_, b)) == 0) continue;
    if (done_.test(b))
      doubts_->set(b, j_, kPartlyShare);
    else
      doubts_->set(b, j_, sees_.test(b) && misses_.test(b) ? kMixedShare : share_of_copied(b, settled));
  }
}

void LocalizedCompletion::note_uniform_doubts() {
  for (const std::uint32_t b : active_blocks_) doubts_->set(b, j_, share_of_copied(b, true));
}

/// Wants an active row in each four of a block where none is traced yet.
void LocalizedCompletion::want_quads(std::size_t b) {
  const std::uint32_t rows = block_of(active_, b), known = block_of(traced_, b);
  const std::uint32_t from = ((turn_ >> 24) + 3 * static_cast<std::uint32_t>(b)) % 4;
  std::uint64_t want = 0;
  for (std::uint32_t q = 0; q < kRowsInBlock; q += 4) {
    const std::uint32_t four = rows >> q & 15;
    if (four == 0 || (known >> q & 15) != 0) continue;
    const std::uint32_t turned = (four | four << 4) >> from;
    want |= std::uint64_t{1} << (q + (static_cast<std::uint32_t>(std::countr_zero(turned)) + from) % 4);
  }
  wanted_[b / kBlocksInWord] |= want << b % kBlocksInWord * kRowsInBlock;
}

/// Predicts the rest of a block of which some rows are traced: as before if they agree with it, uniform if they are,
/// else each four of rows by its majority.
std::uint32_t LocalizedCompletion::fill_quads(std::size_t b) const {
  const std::uint32_t traced = block_of(traced_, b), visible = block_of(column_, b) & traced,
                      predicted = block_of(predicted_, b);
  if (((predicted ^ visible) & traced) == 0) return predicted;
  if (visible == 0 || visible == traced) return visible == 0 ? 0 : 0xffff;
  std::uint32_t filled = 0;
  for (std::uint32_t q = 0; q < kRowsInBlock; q += 4) {
    const std::uint32_t known = traced >> q & 15, seen = visible >> q & 15;
    if (known == 0)
      filled |= predicted & 15u << q;
    else if (2 * std::popcount(seen) > std::popcount(known))
      filled |= 15u << q;
  }
  return filled;
}

void LocalizedCompletion::copy_others() {
  for_each_bit(done_.words(), [&](std::size_t b) {
    if (whole_.test(b)) return;
    const std::size_t word = b / kBlocksInWord, shift = b % kBlocksInWord * kRowsInBlock;
    predicted_[word] = (predicted_[word] & ~(std::uint64_t{0xffff} << shift)) | std::uint64_t{fill_quads(b)} << shift;
  });
  for (std::size_t w = 0; w < words_; ++w) column_[w] |= predicted_[w] & active_[w] & ~traced_[w];
}

void check_count(const char* name, std::uint32_t value) {
  if (value > 0) return;
  throw Error(ErrorKind::usage, std::string("lbamc.") + name + ": must be at least 1, got 0");
}

void check_energy(const char* name, float value) {
  if (value >= 0) return;  // false for NaN
  throw Error(ErrorKind::usage, std::string("lbamc.") + name + ": must not be negative, got " + std::to_string(value));
}

}  // namespace

LocalizedParams with_slack(const LocalizedParams& params, float slack) {
  MYRIALUX_ASSERT(slack > 0);
  LocalizedParams p = params;
  p.watch *= slack, p.settle *= slack, p.guard *= slack, p.copy_mixed *= slack, p.whole *= slack;
  p.risk *= slack * slack;  // of squared energies
  return p;
}

CompletionStats complete_localized(EntrySource& source, const LocalizedParams& params, Rng& rng, BitMatrix& visible,
                                   BlockDoubts* doubts) {
  check_count("first_samples", params.first_samples);
  check_count("samples", params.samples);
  check_count("memory", params.memory);
  check_energy("watch", params.watch);
  check_energy("settle", params.settle);
  check_energy("guard", params.guard);
  check_energy("risk", params.risk);
  check_energy("copy_mixed", params.copy_mixed);
  check_energy("whole", params.whole);
  MYRIALUX_ASSERT(visible.n_rows() == source.n_rows() && visible.n_columns() == source.n_columns());
  if (source.n_rows() == 0) return {};
  return LocalizedCompletion(source, params, rng, visible, doubts).run();
}

}  // namespace myrialux
