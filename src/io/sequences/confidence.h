#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Confidence images beside depth: SequenceOptions::confidence describes the files and values. The
// range of the values is decided once per recording, so that a frame without high values has the
// same limit as all other frames.

// Folder of the confidence images.
std::string ConfidenceFolder(const std::string& folder);

// Sets the confidence image of each frame, and its range. Images are matched to depth
//   1. by the timestamps in confidence.txt, if this file exists. Numbered frames have no clock, and
//      their folder confidence/ takes precedence over the file.
//   2. by the names in confidence/, see AddNamedConfidence().
// Returns a warning if frames remain without a confidence image, and std::nullopt if the folder has
// neither. Throws InputError that names the file if the list is malformed, or if two images have
// the same number.
std::optional<std::string> AddConfidence(const std::string& folder, bool has_clock,
                                         std::vector<FrameFiles>* frames);

// Sets the confidence image of each frame by its name: the name of the depth image except the
// ending, or else the same timestamp within kMaxBetweenImages_s if `has_clock`, or else the same
// number. Calls `twice` with a message if two images have this number.
void AddNamedConfidence(const std::string& confidence_folder, bool has_clock,
                        const DuplicateCallback& twice, std::vector<FrameFiles>* frames);

// Returns the largest value that the confidence images can have: 2 if no value of this image is
// above 2, or else 255.
int ConfidenceRange(const Image<std::uint8_t>& confidence);

// Removes depth of low confidence: of a value below a third of the range. An image of another size
// is resampled by nearest neighbour. Throws InputError that names the file if it cannot be read, if
// its aspect ratio differs from depth, or if a value is above the range.
void RemoveLowConfidence(const FrameFiles& files, FrameImages* images);

}  // namespace surfit
