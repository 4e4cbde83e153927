#include "surfit/registration/projective_association.h"

#include <glog/logging.h>

#include <algorithm>

#include "registration/row_finder.h"

namespace surfit {
namespace {

constexpr int kLanes = Lanes<float>::kCount;

// Of every row_stride-th row.
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
  CHECK_EQ(target.vertex.width(), target.camera.width);
  CHECK_EQ(target.vertex.height(), target.camera.height);
}

int ProjectiveAssociation::block_count() const {
  return (source_.vertex.height() + row_stride_ - 1) / row_stride_;
}

// The last lanes of a row are written as a whole.
int ProjectiveAssociation::block_capacity() const { return source_.vertex.width() + kLanes; }

std::unique_ptr<const PairFinder> ProjectiveAssociation::At(
    const Rigid3d& target_from_source) const {
  return std::make_unique<ProjectiveFinder>(
      ProjectiveSearch{source_, target_, target_from_source, gates_, error_model_, needed_normals_},
      row_stride_);
}

}  // namespace surfit
