// Rows and lights of any kind, eight columns at a time through a buffer that fits the first-level cache. [wang20, 4.6]
#include "myrialux/kernels/shade_general.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/shade_general.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "myrialux/kernels/incident-inl.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kChunk = 8;  ///< columns at a time: 16 KB of Incident

/// Columns [first, first + n) and what arrives from them.
struct Chunk {
  std::size_t first, n;
  const Incident* incident;
};

/// Adds a chunk to the rows of one class.
struct ReceiveVisitor {
  const RowLobes& lobes;
  const GeneralRun& run;
  const Chunk& chunk;
  std::uint64_t class_rows;
  BlockSums& sums;

  template <LobeKind kKind, bool kGgx>
  void visit() const {
    const D d;
    for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
      if (!has_rows(class_rows, row)) continue;
      const RowFields fields{lobes.field, row, run.tables.data(),
                             common_table(lobes, class_rows, row, run.tables.data())};
      const bool track = is_tracked(run, row);
      V3 sum = load(d, sums.rgb, row), removed = load(d, sums.removed, row);
      for (std::size_t k = 0; k < chunk.n; ++k) {
        const std::uint64_t bits = run.visible[chunk.first + k] & class_rows;
        if (!has_rows(bits, row)) continue;
        const Incident& in = chunk.incident[k];
        Mask live = mask_of(d, bits, row);
        const V3 f_cos = evaluate_lobes<kKind, kGgx>(d, fields, load(d, in.w, row), hn::Load(d, in.side + row), live);
        const V3 lit = f_cos * load(d, in.rgb, row);
        const V3 kept = {hn::IfThenElseZero(live, lit.x), hn::IfThenElseZero(live, lit.y),
                         hn::IfThenElseZero(live, lit.z)};
        sum = sum + kept;
        if (track) removed = add_scaled(removed, hn::Load(d, in.excess + row), kept);
      }
      store(d, sum, sums.rgb, row);
      if (track) store(d, removed, sums.removed, row);
    }
  }
};

void shade_general_rows(const RowBlock& rows, const RowLobes& row_lobes, const GeneralRun& run, BlockSums& sums) {
  Incident incident[kChunk];
  for (std::size_t first = 0; first < run.lights.size(); first += kChunk) {
    const Chunk chunk{first, std::min(kChunk, run.lights.size() - first), incident};
    for (std::size_t k = 0; k < chunk.n; ++k)
      find_incident(rows, run, run.lights[first + k], run.visible[first + k], incident[k]);
    for (std::size_t c = 0; c < kLobeClasses; ++c) {
      const std::uint64_t class_rows = row_lobes.rows[c];
      if (class_rows != 0) visit_class(lobe_class(c), ReceiveVisitor{row_lobes, run, chunk, class_rows, sums});
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(shade_general_rows);

void shade_general(const RowBlock& rows, const RowLobes& row_lobes, const GeneralRun& run, BlockSums& sums) {
  MYRIALUX_ASSERT(run.lights.size() == run.visible.size());
  HWY_DYNAMIC_DISPATCH(shade_general_rows)(rows, row_lobes, run, sums);
}

}  // namespace myrialux
#endif
