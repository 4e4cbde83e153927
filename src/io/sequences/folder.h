#pragma once

#include <optional>
#include <string>
#include <vector>

namespace surfit {

// The names of what a folder holds, sorted; empty if there is no such folder.
std::vector<std::string> NamesIn(const std::string& folder);

bool IsFolder(const std::string& path);
bool IsFile(const std::string& path);
// The same, for a file that may be missing, but then altogether: throws InputError naming the path
// where something else has its name, a folder, a pipe or a link to nothing.
bool HasFile(const std::string& path);
bool EndsWith(const std::string& name, const std::string& ending);

// The value of the first run of digits in a file's name, if any: 12 for frame-000012.color.png.
std::optional<long> NumberInName(const std::string& name);

// The time that a file's name is, in seconds: 1763820000.134 for 1763820000.134.png, whatever
// stands before it. Nothing for whole numbers.
std::optional<double> StampInName(const std::string& name);

// The path of a file that a sequence's list names, relative to its folder, after following the
// file's folder if this is a link written out as text: where links are unknown (archives, some file
// systems, git without them), a link to a folder becomes a small file that holds the folder's
// relative path. Data sets share images so. Throws InputError naming the link if it leads beyond
// the folders beside the sequence's.
std::string FollowTextLink(const std::string& folder, const std::string& name);

// The names that a sequence's format may have: tum, icl_nuim, seven_scenes, redwood,
// replica (folders), klg, sens and bag (files), db3 and mcap (files, or folders of them), watch (a
// folder that is being filled).
const std::vector<std::string>& SequenceFormats();

// bag, db3 and mcap: recordings of ROS.
bool IsBag(const std::string& format);
// Whether the format can be a single file, or a folder.
bool MayBeFile(const std::string& format);
bool MayBeFolder(const std::string& format);

// The format of a folder by what it holds, or of a file by its name's ending; never watch. Throws
// InputError naming the path and what was looked for if it is none of them.
std::string DetectFormat(const std::string& path);

}  // namespace surfit
