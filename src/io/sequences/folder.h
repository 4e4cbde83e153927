#pragma once

#include <optional>
#include <string>
#include <vector>

namespace surfit {

// Sorted names of the files and folders in a folder, without names that begin with "._" (macOS).
// Empty if the folder does not exist or is unreadable.
std::vector<std::string> NamesIn(const std::string& folder);

// Test for a folder, and for a regular file, also behind symbolic links. False if the path does not
// exist.
bool IsFolder(const std::string& path);
bool IsFile(const std::string& path);
// Returns whether an optional file exists. Throws InputError naming the path if it is not a regular
// file, for example a folder, a pipe or a dangling symbolic link. False if nothing has this path.
bool HasFile(const std::string& path);
bool EndsWith(const std::string& name, const std::string& ending);

// Whether the name has the ending of an image file, in upper or lower case, also of a format that
// is not supported (.webp).
bool IsImageName(const std::string& name);

// Number of the first digits in a file name: 12 for frame-000012.color.png. Returns std::nullopt
// without digits. Also std::nullopt if the number does not fit into `long`.
std::optional<long> NumberInName(const std::string& name);

// TimeInName() in s.
std::optional<double> StampInName(const std::string& name);

// Returns the path of the file `name` in `folder`, and follows a text link. Data sets share image
// folders by symbolic links. Archives and some file systems replace such a link by a small text
// file with the relative path of the folder. Throws InputError naming the link if its target is
// outside of the parent folder of the sequence. `name` may contain folders. Without a link, or if
// its target does not exist, returns the plain path.
std::string FollowTextLink(const std::string& folder, const std::string& name);

// Names of the sequence formats:
//   folders: tum, icl_nuim, seven_scenes, redwood, replica, nerfstudio, stray_scanner,
//     arkit_scenes, polycam, record3d
//   files: klg, sens, bag, oni
//   files or folders: db3, mcap
//   live: watch (folder of new images), openni2 (camera)
const std::vector<std::string>& SequenceFormats();

// True for recordings of ROS: bag, db3, mcap.
bool IsBag(const std::string& format);
// True if a sequence of the format can be a file, or a folder.
bool MayBeFile(const std::string& format);
bool MayBeFolder(const std::string& format);

// Detects the format of a folder from its files, or of a file from its extension in lower case.
// Never returns a live format. Throws InputError naming the path and the known formats if the
// format is unknown.
std::string DetectFormat(const std::string& path);

}  // namespace surfit
