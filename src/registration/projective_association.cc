#include "surfit/registration/projective_association.h"

#include <glog/logging.h>

#include <algorithm>

#include "registration/row_finder.h"

namespace surfit {
namespace {

constexpr int kLanes = Lanes<float>::kCount;

int CountValid(const FrameLevel& level) {
  const auto& z = level.vertex.z;
  return static_cast<int>(std::count_if(z.begin(), z.end(), [](float depth) { return depth > 0; }));
}

class ProjectiveFinder final : public PairFinder {
 public:
  explicit ProjectiveFinder(const ProjectiveSearch& search) : search_(search) {}

  int Find(int row, int first, PairBuffer* pairs) const override {
    return WithInstructions([&](auto instructions) {
      return RowFinder<decltype(instructions)>(search_).Find(row, first, pairs);
    });
  }

 private:
  ProjectiveSearch search_;
};

}  // namespace

ProjectiveAssociation::ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                                             const AssociationGates& gates,
                                             const ErrorModel& error_model,
                                             NeededNormals needed_normals)
    : source_(source),
      target_(target),
      gates_(gates),
      error_model_(error_model),
      needed_normals_(needed_normals),
      source_count_(CountValid(source)) {
  CHECK_EQ(target.vertex.width(), target.camera.width);
  CHECK_EQ(target.vertex.height(), target.camera.height);
}

// The last lanes of a row are written as a whole.
int ProjectiveAssociation::block_capacity() const { return source_.vertex.width() + kLanes; }

std::unique_ptr<const PairFinder> ProjectiveAssociation::At(
    const Rigid3d& target_from_source) const {
  return std::make_unique<ProjectiveFinder>(ProjectiveSearch{
      source_, target_, target_from_source, gates_, error_model_, needed_normals_});
}

}  // namespace surfit
