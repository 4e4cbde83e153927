#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "surfit/loop_closure/keyframe.h"

namespace surfit {

class OptionVisitor;

// Options of PlaceIndex.
struct PlaceIndexOptions {
  double min_similarity = 0.02;  // minimum PlaceCandidate::similarity

  void Visit(OptionVisitor& visitor);
};

// Match of PlaceIndex::Query().
struct PlaceCandidate {
  int keyframe = 0;  // number of PlaceIndex::Add()
  // Ratio of the query features that are also in the keyframe, in [0, 1]. Rare features have more
  // weight.
  double similarity = 0;
};

// Place recognition without training. Hash tables find descriptors by random bits (Gionis et al.
// 1999; ferns: Ozuysal et al. 2010). Each query feature votes once for each keyframe with a
// descriptor within 48 bits in a common bucket. Results are deterministic. Concurrent queries
// are safe, changes are not.
class PlaceIndex {
 public:
  static constexpr int kTables = 8;  // hash tables, each with its own random bits

  // Throws InputError for invalid options.
  explicit PlaceIndex(const PlaceIndexOptions& options = {});

  // Adds a keyframe by its features. Throws InputError if the number is in the index.
  void Add(int keyframe, const PlaceView& view);
  // Removes a keyframe. The time depends on its number of features and on the size of their
  // buckets. No effect if the keyframe is not in the index.
  void Remove(int keyframe);

  // Returns at most `max_count` keyframes that satisfy `is_wanted` and min_similarity, by
  // descending similarity, then by number. Empty without matches, and for a view without features.
  std::vector<PlaceCandidate> Query(const PlaceView& view, int max_count,
                                    const std::function<bool(int keyframe)>& is_wanted) const;

  int keyframe_count() const { return static_cast<int>(keyframes_.size()); }
  std::size_t Bytes() const;  // memory of the descriptors and their table entries

 private:
  struct Entry {
    BinaryDescriptor descriptor;
    int keyframe;
  };
  struct EntryRange {
    std::size_t begin = 0, end = 0;  // indices of `entries_`
  };
  std::uint32_t HashOf(const BinaryDescriptor& descriptor, int table) const;
  void Insert(const Entry& entry);
  void Compact();

  PlaceIndexOptions options_;
  std::vector<std::vector<int>> chosen_bits_;        // per table
  std::vector<std::vector<std::uint32_t>> buckets_;  // of all tables: indices of `entries_`
  std::vector<Entry> entries_;
  std::size_t unused_ = 0;                         // number of entries of removed keyframes
  std::unordered_map<int, EntryRange> keyframes_;  // by number
};

// Limits the memory of keyframe views. While it exceeds `max_bytes`, removes the view of the older
// of the two keyframes with the most similar poses. The pose difference is the translation plus 2 m
// times the rotation in rad. A single remaining view is removed as well. The keyframe leaves the
// index, but keeps its pose. Numbers in the index are positions in `keyframes`. Returns the
// positions in the order of removal.
std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index);

}  // namespace surfit
