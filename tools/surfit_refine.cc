// Refines a run of surfit_slam: poses, surfels and the camera's calibration, all at once.

#include <gflags/gflags.h>

#include "common/recorded_flags.h"
#include "common/refinement.h"
#include "common/sequence_flags.h"
#include "common/tool_main.h"
#include "surfit/run/refine_run.h"

namespace {

const surfit::RefineRunOptions kRun;
const surfit::RefinementOptions kRefinement;
constexpr double kDegree = 3.14159265358979323846 / 180;

}  // namespace

DEFINE_string(run, "",
              "output folder of surfit_slam; its summary.json says which sequence it read and how, "
              "where flags do not");
DEFINE_string(output, kRun.output, "folder for the results; if empty, refined in the run's folder");
DEFINE_int32(first, kRun.sequence.first, "index of the first frame to read");
DEFINE_int32(last, kRun.sequence.last,
             "index of the last frame to read, inclusive; -1 = to the end");
DEFINE_int32(stride, kRun.sequence.stride, "read every stride-th frame");
DEFINE_bool(free_intrinsics, kRefinement.free_intrinsics, "find fx fy cx cy as well");
DEFINE_bool(free_depth_offset, kRefinement.free_depth_offset,
            "find an offset of inverse depth as well");
DEFINE_bool(free_depth_field, kRefinement.free_depth_field,
            "find how the error of inverse depth varies over the image as well: a polynomial of "
            "the second degree");
DEFINE_double(keyframe_translation_m, kRun.keyframe_translation_m,
              "a frame so far from the last keyframe is one");
DEFINE_double(keyframe_rotation_deg, kRun.keyframe_rotation_rad / kDegree,
              "a frame turned so far from the last keyframe is one");
DEFINE_int32(max_keyframes, kRun.max_keyframes,
             "with more of them, both are enlarged; 0 = no limit");
DEFINE_int32(cells_across, kRefinement.cells_across,
             "columns of square cells of a keyframe's image, with at most one surfel in each");
DEFINE_double(photometric_weight, kRefinement.error_model.photometric_weight,
              "weight of the difference of intensities beside that of surfaces; 0 = surfaces only");
DEFINE_double(intensity_sigma, kRefinement.error_model.intensity_sigma,
              "standard deviation of that difference, of intensities from 0 to 1");
DEFINE_int32(max_rounds, kRefinement.max_rounds, "of making surfels and moving all");
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time, reading included");

namespace surfit::tools {
namespace {

RefineRunOptions OptionsFromFlags() {
  RefineRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.sequence.first = FLAGS_first;
  options.sequence.last = FLAGS_last;
  options.sequence.stride = FLAGS_stride;
  options.trajectory = FLAGS_run + "/trajectory.txt";
  options.output = FLAGS_output.empty() ? FLAGS_run + "/refined" : FLAGS_output;
  options.keyframe_translation_m = FLAGS_keyframe_translation_m;
  options.keyframe_rotation_rad = FLAGS_keyframe_rotation_deg * kDegree;
  options.max_keyframes = FLAGS_max_keyframes;
  options.threads = FLAGS_threads;
  RefinementOptions& refinement = options.refinement;
  refinement.free_intrinsics = FLAGS_free_intrinsics;
  refinement.free_depth_offset = FLAGS_free_depth_offset;
  refinement.free_depth_field = FLAGS_free_depth_field;
  refinement.cells_across = FLAGS_cells_across;
  refinement.error_model.photometric_weight = FLAGS_photometric_weight;
  refinement.error_model.intensity_sigma = FLAGS_intensity_sigma;
  refinement.max_rounds = FLAGS_max_rounds;
  options.record = RecordedFlags();
  return options;
}

int Run() {
  RequireFlag("run", FLAGS_run);
  TakeRecordedFlags(FLAGS_run + "/summary.json",
                    {"sequence", "format", "camera", "intrinsics", "distortion", "depth_scale",
                     "color_intrinsics", "color_distortion", "color_from_depth", "fps",
                     "downsample", "max_depth_m", "first", "last", "stride"});
  return RefineAndPrint(OptionsFromFlags());
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "refines a run of surfit_slam: the poses of keyframes, the surfels that they share and the "
      "camera's calibration by joint least squares; moves the other poses along and fuses the map "
      "anew.",
      surfit::tools::Run);
}
