#pragma once

#include <memory>

#include "surfit/registration/association.h"
#include "surfit/registration/point_set.h"
#include "surfit/registration/residual_type.h"

namespace surfit {

// A point set made ready to be searched, by a KD-tree that all copies share.
class SearchablePoints {
 public:
  explicit SearchablePoints(const PointSet& points);
  int size() const;

 private:
  friend class KdTreeAssociation;
  struct Data;
  std::shared_ptr<const Data> data_;
};

// Which points are paired with their nearest neighbours.
struct KdTreeAssociationOptions {
  AssociationGates gates;
  NeededNormals needed_normals = NeededNormals::kTarget;
  // A pair must be each other's nearest points, the source's among all of its points.
  bool reciprocal = false;
  // Only every stride-th source point is used, in an order of the source's tree that visits all of
  // space evenly.
  int source_stride = 1;
};

// Nearest-neighbour data association (Besl and McKay 1992): a source point p is moved by the pose,
// p' = R p + t, and matched with the target point q nearest to it, of equally near ones the first
// of the target's points. Valid are pairs with the needed normals that pass the gates; the normal
// gate needs both normals. What the last pose found is where the next search starts, which saves
// time and changes nothing.
class KdTreeAssociation final : public Association {
 public:
  KdTreeAssociation(SearchablePoints source, SearchablePoints target,
                    const KdTreeAssociationOptions& options);
  ~KdTreeAssociation() override;

  int source_count() const override;
  int block_count() const override;
  int block_capacity() const override;
  std::unique_ptr<const PairFinder> At(const Rigid3d& target_from_source) const override;

 private:
  class Finder;
  struct LastMatches;

  SearchablePoints source_, target_;
  KdTreeAssociationOptions options_;
  std::unique_ptr<LastMatches> last_matches_;
};

}  // namespace surfit
