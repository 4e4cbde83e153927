#pragma once

#include <functional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// Formats of ExportRun(): colmap, nerfstudio, gaussians, occupancy.
std::vector<std::string> ExportFormatNames();

struct ExportOptions {
  SequenceOptions sequence;  // sequence of the run, with the same options
  std::string run;           // output folder of a run: poses.json, map.ply and summary.json
  std::string output;        // output folder, created if missing
  std::string to;            // one of ExportFormatNames(); required by ExportRun()
  int images = 200;          // colmap, nerfstudio: maximum number of images; 0: all
  bool undistort = false;    // colmap, nerfstudio: write images of a pinhole camera
  // "upright": z is up, the floor is at z = 0, and walls are along x and y. "run": the world frame
  // of map.ply. The world frame stays that of the run if the map does not show its direction of
  // gravity.
  std::string world = "upright";
  int threads = 2;  // ThreadLimit

  void Visit(OptionVisitor& visitor);
};

// Results of ExportRun().
struct ExportSummary {
  std::vector<std::string> messages;  // one line each, for the user
  std::vector<std::string> warnings;
};

// Writes the poses and the map of a run in the format of another program.
//
// colmap:
//   images/N.png            chosen images, as recorded or undistorted
//   sparse/0/*.bin          cameras, images and points3D
//   sparse_text/*.txt       the same as text
// nerfstudio:
//   transforms.json, images/N.png, depth/N.png (mm, rendered from the map), points.ply
//   masks/N.png             0: objects in front of the map, 255: other pixels. Not written if no
//                           image shows such an object.
// gaussians:
//   splats.ply              one flat Gaussian per surfel, in the format of 3D Gaussian splatting.
//                           The colours are fitted to at most 48 images, if there are any.
// occupancy:
//   map.pgm, map.yaml       for the ROS map_server
//   floor_plan.svg          walls, camera path and a scale bar
//
// Each format also has export.json. It has the transform of the world frame with its source and
// uncertainty, the colour camera, and the numbers of used and skipped items. `registration` has the
// changes of poses by RegisterImages(), and the numbers of images that keep the tracked pose.
//
// Poses of images are the poses of the colour camera in the middle of the readout of the image. The
// colour camera is estimated from the images by EstimateColorCamera(). The images of colmap and
// nerfstudio are registered to each other by RegisterImages().
//
// Calls `progress`, which must not be empty, with a line of text. Throws InputError for invalid
// options, unreadable runs and sequences, and results that cannot be written. Also throws it for a
// run without poses or surfels, and if `output` is an input folder. The formats colmap and
// nerfstudio require colour images, occupancy requires an upright world.
ExportSummary ExportRun(const ExportOptions& options,
                        const std::function<void(const std::string&)>& progress);

}  // namespace surfit
