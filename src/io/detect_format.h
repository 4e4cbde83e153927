#pragma once

#include <string>
#include <vector>

namespace surfit {

// The names that a sequence's format may have: tum, icl_nuim, seven_scenes, redwood.
const std::vector<std::string>& SequenceFormats();

// The format of a folder by what it holds. Throws InputError naming the folder and what was looked
// for if it is none of them.
std::string DetectFormat(const std::string& folder);

}  // namespace surfit
