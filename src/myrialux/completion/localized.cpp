// One column after the other; what is known of the column at hand lies in bit masks of rows and of blocks.
#include "myrialux/completion/localized.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/completion/block_masks.h"
#include "myrialux/kernels/nearest_bits.h"

namespace myrialux {
namespace {

/// Columns that the running mean of contradictions looks back on.
constexpr float kColumnsOfDoubt = 64;

/// The nearest other blocks of each block, by the middles of their rows; in the order of the blocks where the source
/// knows of no points.
class BlockNeighbours {
 public:
  BlockNeighbours(const EntrySource& source, std::size_t n_blocks, std::size_t count);
  std::span<const std::uint32_t> of(std::size_t b) const { return std::span(nearest_).subspan(b * count_, count_); }

 private:
  std::size_t count_;
  std::vector<std::uint32_t> nearest_;  ///< [n_blocks * count]
};

/// The completed columns that others are compared with: the last ones, oldest replaced first.
class RememberedColumns {
 public:
  RememberedColumns(std::size_t capacity, std::size_t words) : capacity_(capacity), words_(words) {}
  bool empty() const { return size_ == 0; }
  void add(Words visible, Words known);
  NearestColumn nearest(Words samples, Words omega) const {
    return nearest_column({visible_, known_, words_}, newest_, samples, omega);
  }
  Words visible(std::size_t q) const { return Words(visible_).subspan(q * words_, words_); }
  Words known(std::size_t q) const { return Words(known_).subspan(q * words_, words_); }

 private:
  std::size_t capacity_, words_, size_ = 0, newest_ = 0;
  std::vector<std::uint64_t> visible_, known_;  ///< [size * words]
};

class LocalizedCompletion {
 public:
  LocalizedCompletion(EntrySource& source, const LocalizedParams& params, Rng& rng, BitMatrix& visible);
  CompletionStats run();

 private:
  void complete_column(std::size_t j);
  void trace_whole(std::size_t j);
  void try_traced_column(std::size_t j);
  void list_active_blocks(std::size_t j);
  void begin_column(std::size_t j);
  void want_block(std::size_t j, std::uint32_t b);
  void want_row(std::size_t j, std::uint32_t b);
  bool has_sample(std::size_t b) const;
  void choose_rows(std::size_t j, std::size_t count);
  void sample(std::size_t j, std::size_t count, float great);
  void update_doubt(std::size_t j, Words samples);
  void trace_wanted(std::size_t j);
  bool samples_agree(std::size_t j) const;
  bool is_uniform(std::size_t q, bool value) const;
  void predict(std::size_t q);
  void trace_doubtful_blocks(std::size_t j);
  void spread_doubt();
  void copy_others(std::size_t j);

  EntrySource& source_;
  const LocalizedParams params_;
  BitMatrix& visible_;
  const std::size_t words_, n_blocks_;
  const BlockNeighbours neighbours_;
  RememberedColumns remembered_;
  std::uint32_t turn_;  ///< turns samples over the rows, on and on from column to column
  float doubt_ = 0;     ///< running mean of the share of samples that contradict
  CompletionStats stats_;

  // Of the column at hand.
  std::vector<std::uint64_t> traced_, wanted_;  ///< rows
  std::vector<std::uint64_t> predicted_;        ///< bits of all rows
  std::vector<std::uint32_t> active_blocks_;    ///< those with active rows, ascending
  BlockMask sees_, misses_;                     ///< blocks predicted to have visible, occluded rows; both: mixed
  BlockMask active_;                            ///< active_blocks_ as a mask
  std::vector<float> energies_;                 ///< by block
  BlockMask bright_;                            ///< blocks above copy_mixed
  BlockMask doubtful_, done_, changed_;         ///< to be traced next; traced; traced and not in the state predicted
};

LocalizedCompletion::LocalizedCompletion(EntrySource& source, const LocalizedParams& params, Rng& rng,
                                         BitMatrix& visible)
    : source_(source),
      params_(params),
      visible_(visible),
      words_(visible.words_per_column()),
      n_blocks_(words_ * kBlocksInWord),
      neighbours_(source, n_blocks_, std::min<std::size_t>(params.flood, n_blocks_ - 1)),
      remembered_(params.memory, words_),
      turn_(rng.next_uint()),
      traced_(words_),
      wanted_(words_),
      predicted_(words_),
      sees_(n_blocks_),
      misses_(n_blocks_),
      active_(n_blocks_),
      energies_(n_blocks_),
      bright_(n_blocks_),
      doubtful_(n_blocks_),
      done_(n_blocks_),
      changed_(n_blocks_) {}

CompletionStats LocalizedCompletion::run() {
  for (std::size_t j = 0; j < source_.n_columns(); ++j) complete_column(j);
  return stats_;
}

void LocalizedCompletion::complete_column(std::size_t j) {
  const Words active = source_.active(j);
  const std::size_t n_active = count_bits(active);
  if (n_active == 0) return;
  stats_.entries += n_active;
  std::fill(traced_.begin(), traced_.end(), 0);
  if (n_active <= params_.few || remembered_.empty()) return trace_whole(j);

  if (doubt_ > params_.doubt) return try_traced_column(j);

  // A few rows tell which column this one is like; where all is of one kind, they are enough.
  begin_column(j);
  sample(j, params_.first_samples, params_.settle);
  NearestColumn nearest = remembered_.nearest(visible_.column(j), traced_);
  const bool settled =
      nearest.distance == 0 && samples_agree(j) && is_uniform(nearest.column, count_bits(visible_.column(j)) > 0);
  if (!settled) {
    sample(j, params_.samples - std::min(params_.samples, params_.first_samples), params_.watch);
    nearest = remembered_.nearest(visible_.column(j), traced_);
  }

  // Blocks are copied where nothing speaks against it.
  predict(nearest.column);
  update_doubt(j, traced_);
  trace_doubtful_blocks(j);
  copy_others(j);
  remembered_.add(visible_.column(j), active);
}

void LocalizedCompletion::trace_whole(std::size_t j) {
  const Words active = source_.active(j);
  std::copy(active.begin(), active.end(), wanted_.begin());
  trace_wanted(j);
  ++stats_.full_columns;
  remembered_.add(visible_.column(j), active);
}

/// Traces a column whole and sees how far copies of others would have been wrong.
void LocalizedCompletion::try_traced_column(std::size_t j) {
  const Words active = source_.active(j);
  list_active_blocks(j);
  choose_rows(j, params_.samples);
  const std::vector<std::uint64_t> samples = wanted_;
  std::copy(active.begin(), active.end(), wanted_.begin());
  trace_wanted(j);
  ++stats_.full_columns;
  predict(remembered_.nearest(visible_.column(j), samples).column);
  update_doubt(j, samples);
  remembered_.add(visible_.column(j), active);
}

/// The share of `samples` in blocks predicted uniform that contradict them enters the running mean.
void LocalizedCompletion::update_doubt(std::size_t j, Words samples) {
  const Words column = std::as_const(visible_).column(j);
  std::size_t n_tested = 0, n_contradict = 0;
  for (std::size_t w = 0; w < words_; ++w) {
    const std::uint64_t tested = samples[w] & rows_of_blocks(sees_.four(w) ^ misses_.four(w));
    n_tested += static_cast<std::size_t>(std::popcount(tested));
    n_contradict += static_cast<std::size_t>(std::popcount((predicted_[w] ^ column[w]) & tested));
  }
  if (n_tested == 0) return;
  const float share = static_cast<float>(n_contradict) / static_cast<float>(n_tested);
  doubt_ += (share - doubt_) / kColumnsOfDoubt;
}

void LocalizedCompletion::list_active_blocks(std::size_t j) {
  const Words active = source_.active(j);
  active_.clear();
  for (std::size_t w = 0; w < words_; ++w) active_.add_four(w, any_in_blocks(active[w]));
  active_blocks_.clear();
  for_each_bit(active_.words(), [&](std::size_t b) { active_blocks_.push_back(static_cast<std::uint32_t>(b)); });
}

/// Wants what must be traced.
void LocalizedCompletion::begin_column(std::size_t j) {
  list_active_blocks(j);
  source_.block_energies(j, energies_);
  const Words required = source_.required(j);
  for (std::size_t w = 0; w < words_; ++w) wanted_[w] = required.empty() ? 0 : required[w];
  for (const std::uint32_t b : active_blocks_)
    if (energies_[b] > params_.guard) want_block(j, b);
}

/// All active rows of a block.
void LocalizedCompletion::want_block(std::size_t j, std::uint32_t b) {
  const std::size_t word = b / kBlocksInWord;
  wanted_[word] |= source_.active(j)[word] & rows_of_blocks(std::uint64_t{1} << b % kBlocksInWord);
}

/// Wants one active row of a block.
void LocalizedCompletion::want_row(std::size_t j, std::uint32_t b) {
  const std::size_t word = b / kBlocksInWord, shift = b % kBlocksInWord * kRowsInBlock;
  const std::uint32_t rows = source_.active(j)[word] >> shift & 0xffff;
  const std::uint32_t from = ((turn_ >> 20) + 7 * b) % kRowsInBlock;  // the first active row from there on, in a ring
  const std::uint32_t turned = (rows | rows << kRowsInBlock) >> from;
  const std::uint32_t row = (static_cast<std::uint32_t>(std::countr_zero(turned)) + from) % kRowsInBlock;
  wanted_[word] |= std::uint64_t{1} << (shift + row);
}

/// Wants one row in each of `count` active blocks (as many as there are), evenly spaced. Which blocks, and which of
/// their rows, goes on turning.
void LocalizedCompletion::choose_rows(std::size_t j, std::size_t count) {
  const std::size_t n = active_blocks_.size(), n_taken = std::min(count, n);
  turn_ += 0x9e3779b9u;  // steps of the golden ratio: every stretch of turns is spread evenly
  const std::uint64_t phase = static_cast<std::uint64_t>(turn_) * n >> 32;
  for (std::size_t k = 0; k < n_taken; ++k) want_row(j, active_blocks_[(phase + k * n / n_taken) % n]);
}

/// Traces some rows, and one in each block of great energy that has none yet, besides what is wanted already.
void LocalizedCompletion::sample(std::size_t j, std::size_t count, float great) {
  choose_rows(j, count);
  for (const std::uint32_t b : active_blocks_)
    if (energies_[b] > great && !has_sample(b)) want_row(j, b);
  for (std::size_t w = 0; w < words_; ++w) wanted_[w] &= ~traced_[w];
  trace_wanted(j);
}

bool LocalizedCompletion::has_sample(std::size_t b) const {
  return ((traced_[b / kBlocksInWord] | wanted_[b / kBlocksInWord]) >> b % kBlocksInWord * kRowsInBlock & 0xffff) != 0;
}

/// Traces wanted rows, none of which is traced yet, and forgets what was wanted.
void LocalizedCompletion::trace_wanted(std::size_t j) {
  const std::size_t n = count_bits(wanted_);
  if (n == 0) return;
  stats_.traced += n;
  source_.trace(j, wanted_, visible_.column(j));
  for (std::size_t w = 0; w < words_; ++w) {
    MYRIALUX_ASSERT((traced_[w] & wanted_[w]) == 0);  // no entry is asked for twice
    traced_[w] |= wanted_[w];
    wanted_[w] = 0;
  }
}

/// All traced rows are visible, or none is.
bool LocalizedCompletion::samples_agree(std::size_t j) const {
  const std::size_t n_visible = count_bits(std::as_const(visible_).column(j));
  return n_visible == 0 || n_visible == count_bits(traced_);
}

bool LocalizedCompletion::is_uniform(std::size_t q, bool value) const {
  const Words visible = remembered_.visible(q), known = remembered_.known(q);
  for (std::size_t w = 0; w < words_; ++w)
    if (((value ? ~visible[w] : visible[w]) & known[w]) != 0) return false;
  return true;
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
void LocalizedCompletion::trace_doubtful_blocks(std::size_t j) {
  const Words active = source_.active(j);
  const MutableWords column = visible_.column(j);
  doubtful_.clear();
  done_.clear();
  bright_.clear();
  for (const std::uint32_t b : active_blocks_)
    if (energies_[b] > params_.copy_mixed) bright_.set(b);
  for (std::size_t w = 0; w < words_; ++w) {
    const std::uint64_t sees = sees_.four(w), misses = misses_.four(w), mixed = sees & misses;
    const std::uint64_t contradicted = any_in_blocks((predicted_[w] ^ column[w]) & traced_[w]);
    const std::uint64_t doubtful = contradicted | ~(sees | misses) | (mixed & bright_.four(w));
    doubtful_.add_four(w, doubtful & active_.four(w));
  }
  while (!doubtful_.empty()) {
    for (std::size_t w = 0; w < words_; ++w) wanted_[w] = rows_of_blocks(doubtful_.four(w)) & active[w] & ~traced_[w];
    trace_wanted(j);
    changed_.clear();
    for (std::size_t w = 0; w < words_; ++w) {
      const std::uint64_t sees = any_in_blocks(column[w]), misses = any_in_blocks(active[w] & ~column[w]);
      const std::uint64_t was_known = sees_.four(w) | misses_.four(w);
      const std::uint64_t differs = (sees ^ sees_.four(w)) | (misses ^ misses_.four(w));
      changed_.add_four(w, differs & was_known & doubtful_.four(w));
    }
    spread_doubt();
  }
}

/// Doubtful blocks are done; the neighbours of changed ones become doubtful.
void LocalizedCompletion::spread_doubt() {
  for (std::size_t word = 0; word < done_.n_words(); ++word) done_[word] |= doubtful_[word];
  doubtful_.clear();
  for_each_bit(changed_.words(), [&](std::size_t b) {
    for (const std::uint32_t near : neighbours_.of(b)) doubtful_.set(near);
  });
  for (std::size_t word = 0; word < done_.n_words(); ++word) doubtful_[word] &= active_[word] & ~done_[word];
}

void LocalizedCompletion::copy_others(std::size_t j) {
  const Words active = source_.active(j);
  const MutableWords column = visible_.column(j);
  for (std::size_t w = 0; w < words_; ++w)
    column[w] |= predicted_[w] & active[w] & ~traced_[w] & ~rows_of_blocks(done_.four(w));
}

BlockNeighbours::BlockNeighbours(const EntrySource& source, std::size_t n_blocks, std::size_t count)
    : count_(count), nearest_(n_blocks * count) {
  const std::span<const RowPoint> points = source.row_points();
  std::vector<RowPoint> middles(n_blocks);
  for (std::size_t b = 0; b < n_blocks; ++b) {
    const std::size_t first = std::min(b * kRowsInBlock, source.n_rows()),
                      end = std::min(first + kRowsInBlock, source.n_rows());
    if (points.empty() || first == end) {
      middles[b] = {static_cast<float>(b), 0, 0};
      continue;
    }
    for (std::size_t i = first; i < end; ++i)
      for (std::size_t a = 0; a < 3; ++a) middles[b][a] += points[i][a] / static_cast<float>(end - first);
  }

  using Candidate = std::pair<float, std::uint32_t>;
  std::vector<Candidate> others;
  for (std::size_t b = 0; b < n_blocks; ++b) {
    others.clear();
    for (std::size_t o = 0; o < n_blocks; ++o) {
      float distance = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        const float step = middles[o][a] - middles[b][a];
        distance += step * step;
      }
      if (o != b) others.push_back({distance, static_cast<std::uint32_t>(o)});
    }
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end());
    for (std::size_t k = 0; k < count; ++k) nearest_[b * count + k] = others[k].second;
  }
}

void RememberedColumns::add(Words visible, Words known) {
  if (size_ < capacity_) {
    visible_.insert(visible_.end(), visible.begin(), visible.end());
    known_.insert(known_.end(), known.begin(), known.end());
    newest_ = size_++;
    return;
  }
  newest_ = (newest_ + 1) % capacity_;
  std::copy(visible.begin(), visible.end(), visible_.begin() + static_cast<std::ptrdiff_t>(newest_ * words_));
  std::copy(known.begin(), known.end(), known_.begin() + static_cast<std::ptrdiff_t>(newest_ * words_));
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

CompletionStats complete_localized(EntrySource& source, const LocalizedParams& params, Rng& rng, BitMatrix& visible) {
  check_count("first_samples", params.first_samples);
  check_count("samples", params.samples);
  check_count("memory", params.memory);
  check_energy("watch", params.watch);
  check_energy("settle", params.settle);
  check_energy("guard", params.guard);
  check_energy("doubt", params.doubt);
  check_energy("copy_mixed", params.copy_mixed);
  MYRIALUX_ASSERT(visible.n_rows() == source.n_rows() && visible.n_columns() == source.n_columns());
  if (source.n_rows() == 0) return {};
  return LocalizedCompletion(source, params, rng, visible).run();
}

}  // namespace myrialux
