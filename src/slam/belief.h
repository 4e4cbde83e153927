#pragma once

#include "slam/view_comparison.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/icp.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What is to be thought of a pose.
enum class Verdict {
  kBelieved,  // nothing speaks against it
  kDoubtful,  // it counts if another way leads to the same pose
  kRefuted,   // it is wrong, or nothing holds it
};

// When is a pose believed? By the registration itself, and by what a wrong one cannot fake: the
// frame must not see through surfaces of the model, nor show others before them, but for what
// moves, and the images must be alike where both surfaces are.
class Belief {
 public:
  // Keeps a reference to the options.
  explicit Belief(const SlamOptions& options) : options_(options) {}

  // Of a registration, and the comparison of the views at its pose. `moving` of the cells in front
  // of the model move by themselves.
  Verdict Judge(const IcpResult& icp, const ViewComparison& views, int moving) const;

  // Whether a hand can move a camera so far in this time.
  static bool IsPossible(const Rigid3d& motion, double seconds);

 private:
  bool IsRegistered(const IcpResult& icp) const;

  const SlamOptions& options_;
};

}  // namespace surfit
