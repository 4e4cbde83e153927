#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/bags/messages.h"

namespace surfit {

// The coordinate frames that a bag's tf tells of, each with the first pose that is told of it in
// its parent: between cameras of one device poses do not change.
class FrameTree {
 public:
  void Add(const std::vector<FrameTransform>& transforms);

  // Nothing if the frames are not connected.
  std::optional<Rigid3d> Transform(const std::string& target, const std::string& source) const;

 private:
  // The frame and those that it hangs on, with its own poses in them.
  std::map<std::string, Rigid3d> Ancestors(const std::string& frame) const;

  std::map<std::string, FrameTransform> by_child_;
};

}  // namespace surfit
