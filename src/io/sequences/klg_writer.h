#pragma once

#include <cstdint>
#include <string>

#include "surfit/frame/frame_source.h"

namespace surfit {

class OptionVisitor;

// How the images of a .klg file are written.
struct KlgOptions {
  bool compress_depth = true;  // by zlib, or else raw
  int jpeg_quality = 95;       // of colour, 1 to 100; 0: raw

  void Visit(OptionVisitor& visitor);
};

// What became of a recording's frames.
// What was written.
struct KlgSummary {
  int frames_written = 0;
  int frames_skipped = 0;  // could not be read
  std::int64_t depths_beyond =
      0;  // beyond 65.534 m, which the format cannot hold: written as missing
};

// Writes the frames that remain in `source` as a .klg file (of ElasticFusion and its Logger; see
// the reader), atomically: stamps in whole microseconds, depth in whole millimetres, 0 missing. The
// format tells neither camera nor poses: the camera of these frames is written beside it, as
// F.klg.yaml (ReadCameraYaml), where our reader looks for it.
// Throws InputError for bad options, naming the file if it cannot be written, or if no frame could
// be read.
KlgSummary WriteKlg(FrameSource* source, const std::string& path, const KlgOptions& options);

}  // namespace surfit
