#pragma once

#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/correspondences.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

struct PairBuffer;

// What a pair of points must satisfy beyond being valid.
struct AssociationGates {
  double max_distance_m = 0.1;        // |p' - q|; 0 = off
  double max_normal_angle_rad = 0.5;  // between the rotated source normal and n; 0 = off

  // Throws InputError naming field, value and constraint.
  void Validate() const;
};

// Projective data association (Blais and Levine 1995): a source point p is moved by the pose,
// p' = R p + t, projected into the target's image, and matched with the vertex q and normal n
// found at the nearest pixel (u, v). Valid are pairs with
//   p_z > 0,  p'_z > 0,  0 <= u < W,  0 <= v < H,  q_z > 0 and a normal at q,
// that pass the gates. With the normal gate on, the source point needs a normal as well.
class ProjectiveAssociation {
 public:
  // Keeps references: both levels must outlive this object.
  ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                        const AssociationGates& gates, const ErrorModel& error_model);

  // Associates and sums the normal system in one pass over the source image: single precision for
  // the rows, double for the sums, in an order that does not depend on the number of threads.
  NormalSystem Linearize(const Rigid3d& target_from_source) const;

  // The same pairs, a buffer for each row of the source image.
  std::vector<PairBuffer> CollectRows(const Rigid3d& target_from_source) const;

  // The same pairs as a list, row by row.
  Correspondences Collect(const Rigid3d& target_from_source) const;

  const ErrorModel& error_model() const { return error_model_; }

 private:
  const FrameLevel& source_;
  const FrameLevel& target_;
  AssociationGates gates_;
  ErrorModel error_model_;
};

}  // namespace surfit
