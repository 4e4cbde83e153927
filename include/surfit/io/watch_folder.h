#pragma once

#include <atomic>
#include <memory>

#include "surfit/io/sequence.h"

namespace surfit {

// The frames of a folder that somebody is filling (a phone, a recorder), each as soon as its files
// are whole: numbered PNG images in depth/, and numbered PNG or JPEG images in color/, rgb/ or
// image/ if there is such a folder by the time of the first frame. Frames come in the order of
// their numbers N, stamps are N / frames_per_second; camera as with OpenSequence().
//
// Ends once there is a file `done` in the folder and all that came before it is read, or when
// `stop` becomes true. A frame that is not whole after two seconds, or by the end, is a ReadResult
// with an error, as is one that comes after a later one was taken.
//
// Waits for the first frame that can be read. Throws InputError naming the option at fault, or if
// there is no such frame before the end.
std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop);

}  // namespace surfit
