// Order by how many rows each has settled; counts fade from column to column.
#include "myrialux/visibility/occluder_cache.h"

#include <algorithm>
#include <cmath>

namespace myrialux {
namespace {

/// Rows that a new triangle counts as having settled, so that the next new one does not replace it.
constexpr std::uint32_t kFirstCount = 16;
/// This share of the counts fades with every column.
constexpr std::uint32_t kFadingShare = 4;

}  // namespace

OccluderCache::OccluderCache(const Box3& starts) {
  if (starts.is_empty()) return;
  rows_.radius = 0.5f * starts.diagonal();
  for (int a = 0; a < 3; ++a) {
    rows_.centre[a] = starts.centre()[a];
    rows_.largest += std::max(std::abs(starts.lower[a]), std::abs(starts.upper[a]));
  }
}

void OccluderCache::aim(const KnownEnd& end) {
  end_ = end;
  if (size_ == 0) return;
  // Insertion: the order hardly changes from column to column.
  for (std::size_t k = 1; k < size_; ++k)
    for (std::size_t i = k; i > 0 && counts_[order_[i - 1]] < counts_[order_[i]]; --i)
      std::swap(order_[i - 1], order_[i]);
  for (std::uint32_t& count : counts_) count -= count / kFadingShare;
  find_near();
}

void OccluderCache::find_near() {
  const std::uint32_t near = shadow_planes(corners_, end_, rows_, planes_);
  n_near_ = 0;
  for (std::size_t k = 0; k < size_; ++k)
    if (near >> order_[k] & 1) near_[n_near_++] = order_[k];
}

void OccluderCache::add(const std::array<Vec3, 3>& corners) {
  std::size_t slot = 0;
  if (size_ < kOccluders) {
    slot = size_;
    order_[size_++] = static_cast<std::uint8_t>(slot);
  } else {
    slot = static_cast<std::size_t>(std::min_element(counts_.begin(), counts_.end()) - counts_.begin());
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a) corners_.v[k][a][slot] = corners[k][a];
  counts_[slot] = kFirstCount;
  find_near();
}

}  // namespace myrialux
