#pragma once

#include <string>
#include <vector>

namespace surfit {

// The names that a sequence's format may have: tum, icl_nuim, seven_scenes, redwood,
// replica (folders), klg and sens (files), watch (a folder that is being filled).
const std::vector<std::string>& SequenceFormats();

// Whether the format is one of those that are a single file.
bool IsFileFormat(const std::string& format);

// The format of a folder by what it holds, or of a file by its name's ending; never watch. Throws
// InputError naming the path and what was looked for if it is none of them.
std::string DetectFormat(const std::string& path);

}  // namespace surfit
