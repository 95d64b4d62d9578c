#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace hymm::core {

/// What waits in a search, cheapest first but for the width of a bucket: within one there is no
/// order. What is dearer than the buckets reach waits in a heap, in order, so that memory follows
/// how much waits, and not how much dearer the dearest of it is than the cheapest.
class CheapestFirst {
 public:
  struct Entry {
    float key;
    std::int32_t value;
  };
  /// Enough that the ground of a usual map needs no heap, few enough to look through.
  static constexpr std::size_t kBuckets = 8192;

  /// Empties it. The first bucket begins at `lowest`; where the width is 0 or infinite, all share a
  /// bucket or wait in the heap.
  void begin(float lowest, float width) {
    for (std::size_t i = first_; i < end_; ++i) buckets_[i].clear();
    dear_.clear();
    first_ = end_ = 0;
    lowest_ = lowest;
    width_ = std::max(width, std::numeric_limits<float>::min());
    per_key_ = 1.0F / width_;
  }

  /// What is cheaper than the bucket that is being taken joins it.
  void push(float key, std::int32_t value) {
    const float over = (key - lowest_) * per_key_;
    // False for what is no number, too.
    const bool is_near = over < static_cast<float>(kBuckets) && first_ < kBuckets;
    if (!is_near) {
      dear_.push_back({key, value});
      std::push_heap(dear_.begin(), dear_.end(), isDearer);
      return;
    }
    const std::size_t bucket = std::max(first_, std::size_t(std::max(0.0F, over)));
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
    end_ = std::max(end_, bucket + 1);
    buckets_[bucket].push_back({key, value});
  }

  /// Takes one out. False if nothing is left, or nothing in a bucket that begins below `limit`.
  bool pop(Entry& entry, float limit = std::numeric_limits<float>::infinity()) {
    for (; first_ < end_; ++first_) {
      std::vector<Entry>& bucket = buckets_[first_];
      if (bucket.empty()) continue;
      if (lowest_ + static_cast<float>(first_) * width_ >= limit) return false;
      entry = bucket.back();
      bucket.pop_back();
      return true;
    }
    if (dear_.empty() || dear_.front().key >= limit) return false;
    std::pop_heap(dear_.begin(), dear_.end(), isDearer);
    entry = dear_.back();
    dear_.pop_back();
    return true;
  }

  /// Whether all is taken that may be cheaper than what was taken last.
  bool isThrough() const { return first_ >= end_ || buckets_[first_].empty(); }

 private:
  static bool isDearer(const Entry& a, const Entry& b) { return a.key > b.key; }

  std::vector<std::vector<Entry>> buckets_;
  std::vector<Entry> dear_;          ///< a heap
  std::size_t first_ = 0, end_ = 0;  ///< buckets that may hold something
  float lowest_ = 0.0F, width_ = 1.0F, per_key_ = 1.0F;
};

}  // namespace hymm::core
