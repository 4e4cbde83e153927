#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "surfit/loop_closure/keyframe.h"

namespace surfit {

class OptionVisitor;

// How places are looked up.
struct PlaceIndexOptions {
  int tables = 8;                // of descriptors, each by bits of its own
  int bits = 14;                 // by which a table's descriptors are found, at most 20
  int max_hamming = 48;          // of 256: descriptors that differ by more do not show the same
  double min_similarity = 0.02;  // of a candidate

  void Visit(OptionVisitor& visitor);
};

// A keyframe that may show the place that was asked for.
struct PlaceCandidate {
  int keyframe = 0;
  // From 0 to 1: the share of the view's features that the keyframe has too, each weighted by how
  // few keyframes have it.
  double similarity = 0;
};

// Tells which keyframes look like a view, without any training: each table finds descriptors by a
// random selection of their bits, a fern (Ozuysal et al. 2010) or hash (Gionis et al. 1999), and
// descriptors found and near enough vote for their keyframe. Its time grows with the number of
// features that share a hash, in practice with a small part of all. The same calls give the same
// answers.
class PlaceIndex {
 public:
  // Throws InputError for impossible options.
  explicit PlaceIndex(const PlaceIndexOptions& options = {});

  // Adds what a keyframe shows, under any number that is not in the index.
  void Add(int keyframe, const PlaceView& view);
  // Takes it out again, where it is in.
  void Remove(int keyframe);

  // The keyframes that look most like the view, the best first, ties by their number, of those that
  // `is_wanted`; at most `max_count`.
  std::vector<PlaceCandidate> Query(const PlaceView& view, int max_count,
                                    const std::function<bool(int keyframe)>& is_wanted) const;

  int keyframe_count() const { return static_cast<int>(keyframes_.size()); }
  std::size_t Bytes() const;

 private:
  struct Entry {
    BinaryDescriptor descriptor;
    int keyframe;
  };
  std::uint32_t HashOf(const BinaryDescriptor& descriptor, int table) const;
  void Insert(const Entry& entry);

  PlaceIndexOptions options_;
  std::vector<std::vector<int>> chosen_bits_;        // of each table
  std::vector<std::vector<std::uint32_t>> buckets_;  // of all tables: indices of entries
  std::vector<Entry> entries_;
  std::vector<int> keyframes_;  // in the order added
};

// Bounds the memory of keyframes' views: while they take more than `max_bytes`, the two whose
// cameras are most alike are found, and the view of the older is given up; the keyframe itself
// stays, with its pose. Returns the positions of those given up, in that order, which are also
// taken out of the index.
std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index);

}  // namespace surfit
