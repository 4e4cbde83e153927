#pragma once

#include <cstdint>
#include <string>

#include "surfit/frame/frame_source.h"

namespace surfit {

struct KlgSummary {
  int frames_written = 0;
  int frames_skipped = 0;                // unreadable frames
  std::int64_t depths_out_of_range = 0;  // pixels beyond 65.534 m, written as missing depth
};

// Writes the remaining frames of `source` atomically as a .klg file (format of ElasticFusion, see
// OpenKlg()). Timestamps are rounded to microseconds and depth to millimetres; 0: missing depth.
// Depth is compressed by zlib, and colour by JPEG with quality 95. The format stores no camera and
// no poses. The camera is written to F.klg.yaml (fy < 0 for a mirrored source), which
// OpenSequence() reads. Throws InputError if writing fails, or if no frame is readable. A frame has
// one timestamp, the capture time of depth: latencies are subtracted. Images are written as
// `source` returns them: undistorted and downsampled. `path` must be a regular file or a new name.
KlgSummary WriteKlg(FrameSource* source, const std::string& path);

}  // namespace surfit
