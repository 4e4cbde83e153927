#pragma once

#include <utility>
#include <vector>

#include "surfit/io/frame_source.h"

namespace surfit::testing {

inline std::vector<ReadResult> ReadAll(FrameSource* source) {
  std::vector<ReadResult> results;
  while (auto result = source->Next()) results.push_back(std::move(*result));
  return results;
}

}  // namespace surfit::testing
