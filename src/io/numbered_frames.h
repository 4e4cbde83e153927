#pragma once

#include <string>

#include "io/sequence_files.h"

namespace surfit {

// Pairs the images of two folders by the numbers in their names, in ascending order; stamp_s is
// the number. A frame of which one image is missing is listed with the name it should have, so
// that reading it reports that name. color_folder may be empty: no colour. Throws InputError where
// two images of a folder have the same number.
std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder);

// The folder of colour beside depth/: color/, rgb/ or image/ of `folder`, or "" without one.
std::string FindColorFolder(const std::string& folder);

}  // namespace surfit
