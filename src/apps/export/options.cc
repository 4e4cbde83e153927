#include "surfit/core/options.h"

#include "apps/export/export_run.h"
#include "core/shared_options.h"

namespace surfit {

std::vector<std::string> ExportFormatNames() {
  return {"colmap", "nerfstudio", "gaussians", "occupancy"};
}

void ExportOptions::Visit(OptionVisitor& v) {
  std::vector<std::string> formats = ExportFormatNames();
  formats.insert(formats.begin(), "");
  v.AddPart(sequence, "sequence", "input sequence", OptionalPart());
  v.Group("export");
  v.Add(run, SharedOption("run", Everyday()));
  v.Add(to, "to", "format for the results of --run", OneOf(formats), AsFlag(), Everyday());
  v.Add(images, "images",
        "colmap, nerfstudio: maximum number of images, chosen by sharpness and spacing",
        ZeroIs("all images"), AsFlag(), Everyday());
  v.Add(undistort, "undistort", "colmap, nerfstudio: write undistorted images of a pinhole camera",
        AsFlag(), Everyday());
  v.Add(world, SharedOption("world", OneOf({"upright", "run"}), Everyday()));
  v.Group("output");
  v.Add(output, SharedOption("output", Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
}

}  // namespace surfit
