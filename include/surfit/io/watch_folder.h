#pragma once

#include <atomic>
#include <memory>

#include "surfit/io/sequence.h"

namespace surfit {

// The frames of a folder that is being filled (by a phone or a recorder), each as soon as its files
// are complete: numbered PNG images in depth/, and numbered PNG or JPEG images in color/, rgb/ or
// image/ if that folder exists when the first frame arrives. Frames come in the order of their
// numbers N, with stamps N / frames_per_second and the camera of OpenSequence().
//
// Ends when the folder holds a file `done` and all frames before it are read, or when `stop`
// becomes true. A frame that is still incomplete after two seconds, or at the end, is a ReadResult
// with an error; so is a frame that arrives after a later one was taken.
//
// Waits for the first readable frame. Throws InputError naming the option at fault, or if there is
// no such frame before the end.
std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop);

}  // namespace surfit
