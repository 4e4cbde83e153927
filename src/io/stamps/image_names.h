#pragma once

#include <optional>
#include <string>
#include <vector>

namespace surfit {

// Image file with the number and the time in its name.
struct NamedImage {
  std::string name;
  long number = 0;
  std::string time;  // digits of the time beside the number; empty: none
};

// Numbers the images of one folder, sorted by name. Images without a digit in the name are left
// out.
//
// A name can have several integers, for example d435i_000012.png or 0000012-000000366699.png. The
// number is the integer that differs most often between the names with equally many integers. Among
// equals it is the first integer. If no integer differs, it is the first integer that is not part
// of a word: 12 for d435i_000012.png.
//
// The time is the next integer that ascends with the number, and that has the intervals of a camera
// in ms, us or ns.
std::vector<NamedImage> NumberImages(const std::vector<std::string>& names);

// Digits of a time at the end of a file name: 1763820000.134 for depth_1763820000.134.png. Returns
// std::nullopt for other names, including integers.
std::optional<std::string> TimeInName(const std::string& name);

// Numbers of poses and frames can have different conventions: the numbers of the image names, or
// positions in the folder. Returns the index of the frame for each pose, -1 for a pose without a
// frame. Both lists of numbers must be ascending, which is not checked. The convention is the first
// in this list with the largest number of poses on frames:
//   1. the same numbers
//   2. poses from 0, images from 1
//   3. poses from 1, images from 0
//   4. the first pose belongs to the first image, and later numbers have the same distance
//   5. positions: pose number (first + k) belongs to the image at position k
//
// If images begin at 1 and poses at 0, convention 2 precedes convention 1, unless the last numbers
// are equal.
std::vector<int> FramesOfPoses(const std::vector<long>& poses, const std::vector<long>& frames);

}  // namespace surfit
