// Rows and lights of any kind, eight columns at a time through a buffer that fits the first-level cache. [wang20, 4.6]
#include "myrialux/kernels/shade_general.h"

#include <algorithm>
#include <array>

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

/// Of each vector of rows: the table of its rows of one class, if they share one.
using CommonTables = std::array<const float*, kBlockRows / hn::MaxLanes(D())>;
CommonTables common_tables(const RowLobes& lobes, std::size_t lobe_class_index, const float* tables);

HWY_INLINE V3 same(V s) { return {s, s, s}; }
/// sum + a * b in live lanes; what the others hold may be anything.
HWY_INLINE V3 add_live(Mask live, V3 a, V3 b, V3 sum) {
  return {hn::IfThenElse(live, hn::MulAdd(a.x, b.x, sum.x), sum.x),
          hn::IfThenElse(live, hn::MulAdd(a.y, b.y, sum.y), sum.y),
          hn::IfThenElse(live, hn::MulAdd(a.z, b.z, sum.z), sum.z)};
}

/// Adds a chunk to the rows of one class.
struct ReceiveVisitor {
  const RowLobes& lobes;
  const GeneralRun& run;
  const Chunk& chunk;
  std::uint64_t class_rows;
  const CommonTables& tables;
  BlockSums& sums;

  template <LobeKind kKind, bool kGgx>
  void visit() const {
    const D d;
    for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
      if (!has_rows(class_rows, row)) continue;
      const RowFields fields{lobes.field, row, run.tables.data(), tables[row / hn::Lanes(d)]};
      const bool track = is_tracked(run, row);
      V3 sum = load(d, sums.rgb, row), removed = load(d, sums.removed, row);
      for (std::size_t k = 0; k < chunk.n; ++k) {
        const std::uint64_t bits = run.visible[chunk.first + k] & class_rows;
        if (!has_rows(bits, row)) continue;
        const Incident& in = chunk.incident[k];
        Mask live = mask_of(d, bits, row);
        const V3 f_cos = evaluate_lobes<kKind, kGgx, /*kOverCos=*/false>(d, fields, load(d, in.w, row),
                                                                         hn::Load(d, in.side + row), live);
        const V3 rgb = load(d, in.rgb, row);
        sum = add_live(live, f_cos, rgb, sum);
        if (track) removed = add_live(live, f_cos * rgb, same(hn::Load(d, in.excess + row)), removed);
      }
      store(d, sum, sums.rgb, row);
      if (track) store(d, removed, sums.removed, row);
    }
  }
};

CommonTables common_tables(const RowLobes& lobes, std::size_t lobe_class_index, const float* tables) {
  CommonTables common{};
  if (lobe_class(lobe_class_index).kind == LobeKind::plastic)
    for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(D()))
      common[row / hn::Lanes(D())] = common_table(lobes, lobes.rows[lobe_class_index], row, tables);
  return common;
}

void shade_general_rows(const RowBlock& rows, const RowLobes& row_lobes, const GeneralRun& run, BlockSums& sums) {
  Incident incident[kChunk];
  std::array<CommonTables, kLobeClasses> tables;
  for (std::size_t c = 0; c < kLobeClasses; ++c)
    if (row_lobes.rows[c] != 0) tables[c] = common_tables(row_lobes, c, run.tables.data());
  for (std::size_t first = 0; first < run.lights.size(); first += kChunk) {
    const Chunk chunk{first, std::min(kChunk, run.lights.size() - first), incident};
    for (std::size_t k = 0; k < chunk.n; ++k)
      find_incident(rows, run, run.lights[first + k], run.visible[first + k], incident[k]);
    for (std::size_t c = 0; c < kLobeClasses; ++c) {
      const std::uint64_t class_rows = row_lobes.rows[c];
      if (class_rows != 0)
        visit_class(lobe_class(c), ReceiveVisitor{row_lobes, run, chunk, class_rows, tables[c], sums});
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
