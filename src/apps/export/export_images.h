#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "apps/export/color_images.h"
#include "apps/export/export_run.h"
#include "apps/export/sparse_points.h"
#include "output/output_files.h"
#include "output/recorded_run.h"
#include "surfit/core/error.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Log of an export: progress, messages, and the values of export.json.
class ExportLog {
 public:
  // Keeps the reference. `progress` must not be empty.
  explicit ExportLog(const std::function<void(const std::string&)>& progress)
      : progress_(progress) {}

  template <typename... Parts>
  void Progress(const Parts&... parts) {
    progress_(Concat(parts...));
  }
  template <typename... Parts>
  void Say(const Parts&... parts) {
    summary.messages.push_back(Concat(parts...));
  }
  template <typename... Parts>
  void Warn(const Parts&... parts) {
    summary.warnings.push_back(Concat(parts...));
  }

  Json json;  // export.json
  ExportSummary summary;

 private:
  const std::function<void(const std::string&)>& progress_;
};

// "1.25 degrees".
inline std::string DegreesText(double rad) {
  return Concat(std::round(100 * rad / kRadPerDeg) / 100, " degrees");
}

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
