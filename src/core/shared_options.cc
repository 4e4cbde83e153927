#include "core/shared_options.h"

#include <array>

#include "surfit/core/error.h"

namespace surfit {
namespace {

struct RenamedOption {
  const char *old_name, *name;
};

// Former names of options and result values, sorted by the former name.
constexpr std::array kRenamedOptions = {
    RenamedOption{"FarVerdict", "GlobalRegistrationResult"},
    RenamedOption{"HeldOptions", "ObservabilityOptions"},
    RenamedOption{"JudgedView", "EvaluatedView"},
    RenamedOption{"PrepareOptions", "RectifyOptions"},
    RenamedOption{"aspect_share", "aspect_relative_sigma"},
    RenamedOption{"duplicate_share", "duplicate_ratio"},
    RenamedOption{"focal_share", "focal_relative_sigma"},
    RenamedOption{"found_again", "found_by_search"},
    RenamedOption{"frames_apart", "frames_with_two_motions"},
    RenamedOption{"frames_fused_anew", "frames_reintegrated"},
    RenamedOption{"frames_hurried", "frames_with_longer_map_period"},
    RenamedOption{"free_depth_field", "estimate_depth_field"},
    RenamedOption{"free_depth_offset", "estimate_depth_offset"},
    RenamedOption{"free_directions", "degenerate_directions"},
    RenamedOption{"free_intrinsics", "estimate_intrinsics"},
    RenamedOption{"free_readout", "estimate_readout"},
    RenamedOption{"free_space_share", "free_space_violation_ratio"},
    RenamedOption{"given_center_error", "camera_yaml_center_error"},
    RenamedOption{"given_focal_error", "camera_yaml_focal_error"},
    RenamedOption{"held", "observability"},
    RenamedOption{"initialization", "start"},
    RenamedOption{"inlier_share", "inlier_ratio"},
    RenamedOption{"kept_angle_share", "kept_angle_ratio"},
    RenamedOption{"kept_kernel_share", "kept_kernel_ratio"},
    RenamedOption{"known", "camera_yaml_times"},
    RenamedOption{"lasting_confidence", "min_inactive_confidence"},
    RenamedOption{"lead", "score_margin"},
    RenamedOption{"least_sharpness", "min_sharpness"},
    RenamedOption{"max_alike", "max_similar"},
    RenamedOption{"max_dormant_frames", "max_inactive_frames"},
    RenamedOption{"max_free_space_share", "max_free_space_violation_ratio"},
    RenamedOption{"min_inlier_share", "min_inlier_ratio"},
    RenamedOption{"min_lead", "min_score_margin"},
    RenamedOption{"min_overlap_share", "min_overlap_ratio"},
    RenamedOption{"min_piece_m", "min_component_m"},
    RenamedOption{"model_error_share", "model_error_ratio"},
    RenamedOption{"odometry_share", "odometry_ratio"},
    RenamedOption{"overlap_share", "overlap_ratio"},
    RenamedOption{"pieces_dropped", "components_dropped"},
    RenamedOption{"poorly_held_photometric_weight", "weakly_constrained_photometric_weight"},
    RenamedOption{"prepare", "rectify"},
    RenamedOption{"prior_aspect_share", "prior_aspect_relative_sigma"},
    RenamedOption{"prior_focal_share", "prior_focal_relative_sigma"},
    RenamedOption{"radius_share", "radius_ratio"},
    RenamedOption{"sure_inlier_share", "confident_inlier_ratio"},
    RenamedOption{"turn_acceleration_rad_per_s2", "angular_acceleration_rad_per_s2"},
};

const std::vector<Option>& SharedOptions() {
  static const std::vector<Option> kOptions = {
      {"calibrate",
       "calibrate the depth camera during tracking, from keyframes: focal lengths, principal "
       "point and the depth error over the image"},
      {"downsample", "keep every n-th column and row", Between(1, 16)},
      {"estimate", "estimated trajectory, TUM format"},
      {"fit_mount",
       "fit a constant offset between the bodies of the estimate and of the ground truth, for "
       "ground truth of a marker or of another camera",
       AsFlag()},
      {"groundtruth",
       "ground truth trajectory: TUM format, or .gt.freiburg of ICL-NUIM; device: the poses by the "
       "phone that recorded the sequence, not of surfit_evaluate; empty: the trajectory of the "
       "sequence"},
      {"inverse_depth_sigma", "noise of the depth sensor: standard deviation of inverse depth",
       AtLeast(0), Below(1), InUnit("1/m")},
      {"map", "map: a PLY or PCD file with points or surfels"},
      {"max_keyframes",
       "maximum number of keyframes; the keyframe distance and angle grow to satisfy this limit",
       ZeroIs("no limit")},
      {"output", "folder or file for the results; created if missing"},
      {"pictures", "write images of the results"},
      {"run", "output folder of surfit_slam"},
      {"seed", "seed of the random numbers"},
      {"sequence",
       "sequence to read: a folder, a .klg, .sens, .bag, .db3, .mcap, .oni or .mkv file, the URI "
       "of a "
       "camera, or any for the first camera"},
      {"session", "session folder, in which surfit_slam saves the state of its runs"},
      {"source", "source cloud, which is transformed to the target: PLY or PCD, in m"},
      {"summary", "JSON file for all results and options; empty: none"},
      {"target", "target cloud: PLY or PCD, in m"},
      {"threads", "maximum number of threads that compute at the same time", Between(1, 1024)},
      {"world",
       "world frame of pictures, report and exports; upright: z up, floor at 0, walls along the "
       "axes, if the map shows them; run: the frame of the first pose"},
  };
  return kOptions;
}

}  // namespace

Option SharedOption(const std::string& flag) {
  for (const Option& option : SharedOptions()) {
    if (option.name != flag) continue;
    Option shared = option;
    AsFlag()(shared);
    return shared;
  }
  throw InputError(Concat("no option '", flag, "' is shared"));
}

OptionRule InField(const std::string& field) {
  return [=](Option& o) { o.name = field; };
}

std::string OldName(const std::string& name) {
  for (const RenamedOption& renamed : kRenamedOptions) {
    if (name == renamed.name) return renamed.old_name;
  }
  return name;
}

std::string PresentName(const std::string& name) {
  for (const RenamedOption& renamed : kRenamedOptions) {
    if (name == renamed.old_name) return renamed.name;
  }
  return name;
}

}  // namespace surfit
