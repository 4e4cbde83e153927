#include "io/bags/frame_tree.h"

namespace surfit {

void FrameTree::Add(const std::vector<FrameTransform>& transforms) {
  for (const FrameTransform& transform : transforms) by_child_.emplace(transform.child, transform);
}

std::map<std::string, Rigid3d> FrameTree::Ancestors(const std::string& frame) const {
  std::map<std::string, Rigid3d> found{{frame, Rigid3d()}};
  Rigid3d pose;
  for (auto link = by_child_.find(frame); link != by_child_.end();
       link = by_child_.find(link->second.parent)) {
    pose = link->second.parent_from_child * pose;
    if (!found.emplace(link->second.parent, pose).second) break;  // a damaged tree has a ring
  }
  return found;
}

// Both hang on the same frames; which of these is taken does not matter but for rounding.
std::optional<Rigid3d> FrameTree::Transform(const std::string& target,
                                            const std::string& source) const {
  const auto targets = Ancestors(target), sources = Ancestors(source);
  for (const auto& [frame, frame_from_target] : targets) {
    const auto shared = sources.find(frame);
    if (shared != sources.end()) return frame_from_target.Inverse() * shared->second;
  }
  return std::nullopt;
}

}  // namespace surfit
