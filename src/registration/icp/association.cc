#include "surfit/registration/association.h"

#include <algorithm>
#include <cstring>

#include "registration/icp/row_finder.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Each block writes to its own buffer range of full capacity. Afterwards, the ranges are compacted
// in place.
PairBuffer Association::Collect(const Rigid3d& target_from_source) const {
  constexpr int kGrain = 8;
  const auto finder = At(target_from_source);
  const int blocks = block_count(), capacity = block_capacity();
  PairBuffer pairs;
  pairs.SetCapacity(blocks * capacity);
  std::vector<int> sizes(blocks);
  ParallelFor(0, blocks, kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) sizes[i] = finder->Find(i, i * capacity, &pairs);
  });
  const auto arrays = pairs.Arrays();
  ParallelFor(0, PairBuffer::kArrays, 1, [&](int k, int) {
    float* const values = arrays[k]->data();
    float* to = values;
    for (int i = 0; i < blocks; ++i) {
      std::memmove(to, values + i * capacity, sizes[i] * sizeof(float));
      to += sizes[i];
    }
  });
  for (const int size : sizes) pairs.size += size;
  return pairs;
}

Correspondences Moved(Correspondences pairs, const Rigid3d& motion) {
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p = motion * pairs.p(i), m = motion.rotation * pairs.m(i);
    pairs.px[i] = p.x(), pairs.py[i] = p.y(), pairs.pz[i] = p.z();
    pairs.mx[i] = m.x(), pairs.my[i] = m.y(), pairs.mz[i] = m.z();
  }
  return pairs;
}

namespace {

constexpr int kLanes = Lanes<float>::kCount;

// Number of pixels with depth in every row_stride-th row.
int CountValid(const FrameLevel& level, int row_stride) {
  const auto& z = level.vertex.z;
  int count = 0;
  for (int v = 0; v < z.height(); v += row_stride) {
    count += static_cast<int>(
        std::count_if(z.row(v), z.row(v) + z.width(), [](float depth) { return depth > 0; }));
  }
  return count;
}

class ProjectiveFinder final : public PairFinder {
 public:
  explicit ProjectiveFinder(const ProjectiveSearch& search, int row_stride)
      : search_(search), row_stride_(row_stride) {}

  int Find(int block, int first, PairBuffer* pairs) const override {
    return WithInstructions([&](auto instructions) {
      return RowFinder<decltype(instructions)>(search_).Find(block * row_stride_, first, pairs);
    });
  }

 private:
  ProjectiveSearch search_;
  int row_stride_;
};

}  // namespace

ProjectiveAssociation::ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                                             const AssociationGates& gates,
                                             const ErrorModel& error_model,
                                             NeededNormals needed_normals, int row_stride)
    : source_(source),
      target_(target),
      gates_(gates),
      error_model_(error_model),
      needed_normals_(needed_normals),
      row_stride_(row_stride),
      source_count_(CountValid(source, row_stride)) {
  ThrowIf(target.vertex.width() != target.camera.width ||
              target.vertex.height() != target.camera.height,
          "the target has ", target.vertex.width(), " x ", target.vertex.height(),
          " points, must have ", target.camera.width, " x ", target.camera.height,
          " like its camera");
}

int ProjectiveAssociation::block_count() const {
  return (source_.vertex.height() + row_stride_ - 1) / row_stride_;
}

// kLanes extra pairs: the last vector store of a row writes all lanes.
int ProjectiveAssociation::block_capacity() const { return source_.vertex.width() + kLanes; }

std::unique_ptr<const PairFinder> ProjectiveAssociation::At(
    const Rigid3d& target_from_source) const {
  return std::make_unique<ProjectiveFinder>(
      ProjectiveSearch{source_, target_, target_from_source, gates_, error_model_, needed_normals_},
      row_stride_);
}

PointSet PointSetOf(const FrameLevel& level, const ErrorModel& error_model) {
  PointSet set;
  for (int v = 0; v < level.vertex.height(); ++v) {
    for (int u = 0; u < level.vertex.width(); ++u) {
      const Eigen::Vector3f point = level.vertex(u, v);
      if (!(point.z() > 0)) continue;
      set.Add(point, level.normal(u, v),
              static_cast<float>(error_model.Sigma(point.z(), level.noise)));
    }
  }
  return set;
}

}  // namespace surfit
