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

// Correspondences of two surfaces as structure of arrays, in the target frame, m. The first `size`
// values of each array are valid.
template <typename S>
struct Pairs {
  using Vector3 = Eigen::Matrix<S, 3, 1>;

  RawVector<S> px, py, pz;   // source point after the motion: p' = R p + t
  RawVector<S> qx, qy, qz;   // target point
  RawVector<S> nx, ny, nz;   // unit normal of the target; (0, 0, 0): unknown
  RawVector<S> mx, my, mz;   // rotated unit normal of the source; (0, 0, 0): unknown
  RawVector<S> information;  // 1 / sigma^2 of the residual, 1/m^2 (ErrorModel)
  int size = 0;

  static constexpr int kArrays = 13;
  std::array<RawVector<S>*, kArrays> Arrays() {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  std::array<const RawVector<S>*, kArrays> Arrays() const {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  // Sets the length of all arrays. Requires a capacity of at least `size`.
  void SetCapacity(int capacity) {
    for (auto* array : Arrays()) array->resize(capacity);
  }
  // Writes correspondence i, which must be below the capacity. Does not change `size`.
  void Set(int i, const Vector3& p, const Vector3& q, const Vector3& n, const Vector3& m,
           S pair_information) {
    px[i] = p.x(), py[i] = p.y(), pz[i] = p.z();
    qx[i] = q.x(), qy[i] = q.y(), qz[i] = q.z();
    nx[i] = n.x(), ny[i] = n.y(), nz[i] = n.z();
    mx[i] = m.x(), my[i] = m.y(), mz[i] = m.z();
    information[i] = pair_information;
  }
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

using PairBuffer = Pairs<float>;        // result of an Association
using Correspondences = Pairs<double>;  // input of the caller

// Correspondences after a further motion of the source in the target frame.
Correspondences Moved(Correspondences pairs, const Rigid3d& motion);

class OptionVisitor;

// Association gates: thresholds on distance and normal angle of a correspondence.
struct AssociationGates {
  double max_distance_m = 0.1;        // |p' - q|; 0: no limit
  double max_normal_angle_rad = 0.5;  // between the rotated source normal and n; 0: no limit

  void Visit(OptionVisitor& visitor);
};

// Finds correspondences at one pose. Must not outlive its Association. Implementations must be
// thread-safe.
class PairFinder {
 public:
  virtual ~PairFinder() = default;
  // Writes the correspondences of one block of source points to `pairs`, beginning at index
  // `first`, and returns their number. Does not change the size of `pairs`. The values in [first,
  // first + block_capacity()) must exist and may be overwritten. Different blocks may be searched
  // in parallel if their ranges are disjoint.
  virtual int Find(int block, int first, PairBuffer* pairs) const = 0;
};

// Data association between source and target points. The source points are divided into blocks in a
// fixed order, so sums over all correspondences do not depend on the number of threads.
class Association {
 public:
  virtual ~Association() = default;
  virtual int source_count() const = 0;    // used source points with depth
  virtual int block_count() const = 0;     // number of blocks of source points
  virtual int block_capacity() const = 0;  // maximum number of values that Find() writes per block
  // Prepares the search at a pose. Thread-safe.
  virtual std::unique_ptr<const PairFinder> At(const Rigid3d& target_from_source) const = 0;

  // Correspondences of all blocks in block order. The arrays are longer than `size`. Searches in
  // parallel.
  PairBuffer Collect(const Rigid3d& target_from_source) const;
};

// Projective data association (Blais and Levine 1995). Moves a source point p by the pose, p' = R p
// + t, and projects p' into the target image. The target point is the vertex q with normal n at the
// nearest pixel (u, v). A correspondence must have the needed normals, pass the gates and satisfy
//   p_z > 0,  p'_z > 0,  0 <= u < W,  0 <= v < H,  q_z > 0.
// The normal gate needs both normals. A block is a row of the source image; every row_stride-th row
// is used.
class ProjectiveAssociation final : public Association {
 public:
  // Stores references: both levels must outlive this object. Requires row_stride >= 1, which is not
  // checked. Throws if the vertex map of the target differs in size from its camera.
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

// Unordered points of a surface. All vectors have the same size.
struct PointSet {
  std::vector<Eigen::Vector3f> points;   // m, finite
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0): unknown
  std::vector<float> sigma_m;            // standard deviation of the residual of a point, > 0

  std::size_t size() const { return points.size(); }
  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float point_sigma_m) {
    points.push_back(point);
    normals.push_back(normal);
    sigma_m.push_back(point_sigma_m);
  }
};

// Valid points of a frame, in the camera frame, with the standard deviations of the error model.
PointSet PointSetOf(const FrameLevel& level, const ErrorModel& error_model);

// Point set with a KD-tree, copied from its argument. Copies share the data. Throws if the vectors
// of the point set have different sizes.
class SearchablePoints {
 public:
  explicit SearchablePoints(const PointSet& points);
  int size() const;

 private:
  friend class KdTreeAssociation;
  struct Data;
  std::shared_ptr<const Data> data_;
};

// Options of KdTreeAssociation.
struct KdTreeAssociationOptions {
  AssociationGates gates;
  NeededNormals needed_normals = NeededNormals::kTarget;
  // Requires mutual nearest neighbours. The search in the source includes all source points.
  bool reciprocal = false;
  // Uses every source_stride-th source point, at least 1. The order is that of the KD-tree, so the
  // selection is spatially uniform.
  int source_stride = 1;
};

// Nearest-neighbour data association (Besl and McKay 1992). Moves a source point p by the pose, p'
// = R p + t, and finds the nearest target point q. The first point of the set wins a tie. Throws if
// source_stride < 1. A correspondence must have the needed normals and pass the gates. The normal
// gate needs both normals. Searches start at the match of the previous pose, which changes the
// speed but not the result. Keeps both point sets alive.
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
