#pragma once

#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/residual_type.h"

namespace surfit {

// Projective data association (Blais and Levine 1995): a source point p is moved by the pose,
// p' = R p + t, projected into the target's image, and matched with the vertex q and normal n
// found at the nearest pixel (u, v). Valid are pairs with
//   p_z > 0,  p'_z > 0,  0 <= u < W,  0 <= v < H,  q_z > 0 and the needed normals,
// that pass the gates. The normal gate needs both normals. A block is a row of the source image, of
// which every row_stride-th is used.
class ProjectiveAssociation final : public Association {
 public:
  // Keeps references: both levels must outlive this object.
  ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                        const AssociationGates& gates, const ErrorModel& error_model,
                        NeededNormals needed_normals = NeededNormals::kTarget, int row_stride = 1);

  int source_count() const override { return source_count_; }
  int block_count() const override;
  int block_capacity() const override;
  std::unique_ptr<const PairFinder> At(const Rigid3d& target_from_source) const override;

 private:
  const FrameLevel& source_;
  const FrameLevel& target_;
  AssociationGates gates_;
  ErrorModel error_model_;
  NeededNormals needed_normals_;
  int row_stride_;
  int source_count_;
};

}  // namespace surfit
