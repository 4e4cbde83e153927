#pragma once

#include <string>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Confidence images beside depth: SequenceOptions::confidence describes the files and values. The
// range of the values is decided once per recording, so that a frame without high values has the
// same limit as all other frames.

// Returns `folder`/confidence, which may not exist.
std::string ConfidenceFolder(const std::string& folder);

// Sets the confidence image of each frame, and its range from up to eight of the first images.
// Images are matched to depth
//   1. by the timestamps in confidence.txt, if this file exists. Numbered frames have no clock, and
//      their folder confidence/ takes precedence over the file.
//   2. by the names in confidence/, see AddNamedConfidence().
// Adds a warning if frames remain without a confidence image, except if the folder has neither.
// Throws InputError that names the file if the list is malformed, or if two images have the same
// number. Also throws if the clock of the images does not start as often as the clock of the
// frames.
void AddConfidence(const std::string& folder, bool has_clock, std::vector<FrameFiles>* frames,
                   std::vector<std::string>* warnings);

// Sets the confidence image of each frame by the name of the image. The first match is used:
// - name of the depth image, except the ending
// - if `has_clock`: timestamp of the depth image, within kMaxBetweenImages_s
// - number of the depth image, see NumberImages()
//
// If two images have this number, calls `twice` with a message, and uses the image with the first
// name. Frames without a match stay without image. Does not set the range. Throws InputError for
// clocks as AddConfidence().
void AddNamedConfidence(const std::string& confidence_folder, bool has_clock,
                        const DuplicateCallback& twice, std::vector<FrameFiles>* frames);

// Sets the range of all frames from up to eight of the first images. Adds a warning if frames have
// no confidence image.
void SetConfidenceRange(std::vector<FrameFiles>* frames, std::vector<std::string>* warnings);

// Returns the largest value that the confidence images can have: 2 if no value of this image is
// above 2, or else 255.
int ConfidenceRange(const Image<std::uint8_t>& confidence);

// Removes depth with a confidence below a third of the range. An image of another size is resampled
// by nearest neighbour. Throws InputError naming the file for an unreadable file, an aspect ratio
// unlike that of depth, or a value above the range. Removed depth is 0. Also sets
// FrameImages::low_confidence. `files` must have a confidence image and a range.
void RemoveLowConfidence(const FrameFiles& files, FrameImages* images);

}  // namespace surfit
