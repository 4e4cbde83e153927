#pragma once

#include <memory>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/pairs.h"

namespace surfit {

class OptionVisitor;

// What a pair of points must satisfy beyond being valid.
struct AssociationGates {
  double max_distance_m = 0.1;        // |p' - q|; 0 = off
  double max_normal_angle_rad = 0.5;  // between the rotated source normal and n; 0 = off

  void Visit(OptionVisitor& visitor);
};

// Finds pairs at one pose.
class PairFinder {
 public:
  virtual ~PairFinder() = default;
  // Writes the pairs of a block of source points from an index on, and returns how many there are;
  // for the association's block_capacity() pairs there must be room, whose rest is unspecified
  // afterwards. The size of `pairs` stays. Blocks may be asked for at the same time.
  virtual int Find(int block, int first, PairBuffer* pairs) const = 0;
};

// Decides which source point belongs to which target point. Source points come in blocks of a
// fixed order, so that sums over all pairs are the same at any number of threads.
class Association {
 public:
  virtual ~Association() = default;
  virtual int source_count() const = 0;    // valid source points
  virtual int block_count() const = 0;     // of source points
  virtual int block_capacity() const = 0;  // room for the pairs of a block
  virtual std::unique_ptr<const PairFinder> At(const Rigid3d& target_from_source) const = 0;

  // The pairs of all blocks, in their order.
  PairBuffer Collect(const Rigid3d& target_from_source) const;
};

}  // namespace surfit
