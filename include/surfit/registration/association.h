#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Matched points of two surfaces as structure of arrays, in the target's frame. Values count up to
// size; the arrays may be longer.
template <typename S>
struct Pairs {
  using Vector3 = Eigen::Matrix<S, 3, 1>;

  RawVector<S> px, py, pz;   // source point, moved: p' = R p + t
  RawVector<S> qx, qy, qz;   // target point
  RawVector<S> nx, ny, nz;   // unit normal of the target; (0, 0, 0) if unknown
  RawVector<S> mx, my, mz;   // unit normal of the source, rotated; (0, 0, 0) if unknown
  RawVector<S> information;  // 1 / sigma^2 of the residual, 1/m^2 (ErrorModel)
  int size = 0;

  static constexpr int kArrays = 13;
  std::array<RawVector<S>*, kArrays> Arrays() {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  std::array<const RawVector<S>*, kArrays> Arrays() const {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  // Makes room for so many pairs, at least size, without changing size.
  void SetCapacity(int capacity) {
    for (auto* array : Arrays()) array->resize(capacity);
  }
  // Writes a pair at an index for which there is room; size stays.
  void Set(int i, const Vector3& p, const Vector3& q, const Vector3& n, const Vector3& m,
           S pair_information) {
    px[i] = p.x(), py[i] = p.y(), pz[i] = p.z();
    qx[i] = q.x(), qy[i] = q.y(), qz[i] = q.z();
    nx[i] = n.x(), ny[i] = n.y(), nz[i] = n.z();
    mx[i] = m.x(), my[i] = m.y(), mz[i] = m.z();
    information[i] = pair_information;
  }
  // Appends a pair, making room where needed.
  void Add(const Vector3& p, const Vector3& q, const Vector3& n, const Vector3& m,
           S pair_information) {
    if (size == static_cast<int>(px.size())) SetCapacity(2 * size + 16);
    Set(size++, p, q, n, m, pair_information);
  }

  Vector3 p(int i) const { return {px[i], py[i], pz[i]}; }
  Vector3 q(int i) const { return {qx[i], qy[i], qz[i]}; }
  Vector3 n(int i) const { return {nx[i], ny[i], nz[i]}; }
  Vector3 m(int i) const { return {mx[i], my[i], mz[i]}; }
};

using PairBuffer = Pairs<float>;        // what associations find
using Correspondences = Pairs<double>;  // given from elsewhere

// The pairs after the source has moved by a further transform of the target's frame.
Correspondences Moved(Correspondences pairs, const Rigid3d& motion);

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

// Points of a surface in no particular order; all of these have the same size.
struct PointSet {
  std::vector<Eigen::Vector3f> points;   // metres, finite
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0) if unknown
  std::vector<float> sigma_m;            // standard deviation of a residual of the point

  std::size_t size() const { return points.size(); }
  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float point_sigma_m) {
    points.push_back(point);
    normals.push_back(normal);
    sigma_m.push_back(point_sigma_m);
  }
};

// The valid points of a frame, with the error model's sigma for their depth.
PointSet PointSetOf(const FrameLevel& level, const ErrorModel& error_model);

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
