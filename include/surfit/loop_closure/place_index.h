#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "surfit/loop_closure/keyframe.h"

namespace surfit {

class OptionVisitor;

// Options of PlaceIndex.
struct PlaceIndexOptions {
  int tables = 8;                // hash tables of descriptors, each with its own random bits
  int bits = 14;                 // bits of a hash, at most 20
  int max_hamming = 48;          // maximum Hamming distance of matching descriptors, of 256 bits
  double min_similarity = 0.02;  // minimum PlaceCandidate::similarity

  void Visit(OptionVisitor& visitor);
};

// Candidate keyframe for a query view.
struct PlaceCandidate {
  int keyframe = 0;
  // Ratio of the features of the query view that the keyframe has as well, in [0, 1]. Features that
  // few keyframes have are weighted more.
  double similarity = 0;
};

// Place recognition without training. Each table finds descriptors by a random selection of their
// bits, a fern (Ozuysal et al. 2010) or hash (Gionis et al. 1999). Descriptors within `max_hamming`
// vote for their keyframe. The time of a query grows with the number of features that share a hash,
// in practice a small part of all features. Results are deterministic. Concurrent queries are safe.
class PlaceIndex {
 public:
  // Throws InputError for invalid options.
  explicit PlaceIndex(const PlaceIndexOptions& options = {});

  // Adds a keyframe under a number that is not in the index. Aborts if the number is in the index.
  void Add(int keyframe, const PlaceView& view);
  // Removes a keyframe. No effect if it is not in the index. Rebuilds all tables.
  void Remove(int keyframe);

  // Returns at most `max_count` keyframes that satisfy `is_wanted`, by descending similarity, then
  // by their number.
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
  std::vector<std::vector<int>> chosen_bits_;        // per table
  std::vector<std::vector<std::uint32_t>> buckets_;  // of all tables: indices of `entries_`
  std::vector<Entry> entries_;
  std::vector<int> keyframes_;  // in insertion order
};

// Limits the memory of keyframe views. While they exceed `max_bytes`, finds the two keyframes with
// the most similar poses and removes the view of the older keyframe, also from the index. The
// keyframe keeps its pose. Returns the positions of these keyframes, in the order of removal.
// Keyframes have their positions as numbers in the index.
std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index);

}  // namespace surfit
