#pragma once

#include <vector>

#include "apps/export/color_images.h"
#include "apps/export/export_log.h"
#include "apps/export/export_run.h"
#include "apps/export/sparse_points.h"
#include "output/recorded_run.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Images of an export with poses, in ascending order of their frames, and their colour camera.
struct ExportImages {
  ColorCamera given_camera;  // GivenColorCamera()
  ColorCamera camera;        // estimated from the images, or as given
  std::vector<PosedImage> posed;

  std::vector<ColorImage> Sources() const;
};

// Chooses at most `most` colour images of a run; 0: all. Estimates the colour camera, and registers
// the images to each other. The format gaussians uses the given camera and the tracked poses,
// because its Gaussians have the colours of the map. Reports to `log`, which must not be null.
// Throws InputError if the sequence cannot be read, has another camera than the run, or has no
// image with colour and a pose.
ExportImages PrepareImages(const ExportOptions& options, const RecordedRun& run,
                           const SurfelMap& map, int most, ExportLog* log);

}  // namespace surfit
