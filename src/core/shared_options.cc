#include "core/shared_options.h"

#include <array>

#include "surfit/core/error.h"

namespace surfit {
namespace {

struct RenamedOption {
  const char *old_name, *name;
};

// In alphabetical order.
constexpr std::array kRenamedOptions = {
    // RENAMED
    RenamedOption{"max_dormant_frames", "max_inactive_frames"},
};

const std::vector<Option>& SharedOptions() {
  static const std::vector<Option> kOptions = {
      {"color_latency_s", "latency of colour in addition to the latency of depth", Between(-1, 1),
       InUnit("s")},
      {"downsample", "keep every n-th column and row", Between(1, 16)},
      {"estimate", "estimated trajectory, TUM format"},
      {"fit_mount",
       "fit a constant offset between the bodies of the estimate and of the ground truth, for "
       "ground truth of a marker or of another camera",
       AsFlag()},
      {"groundtruth",
       "ground truth trajectory: TUM format, or .gt.freiburg of ICL-NUIM; empty: the trajectory of "
       "the sequence"},
      {"inverse_depth_sigma", "noise of the depth sensor: standard deviation of inverse depth",
       AtLeast(0), Below(1), InUnit("1/m")},
      {"latency_s",
       "time from the middle of exposure and readout of the depth image to its timestamp",
       Between(-1, 1), InUnit("s")},
      {"map", "map: a PLY or PCD file with points or surfels"},
      {"max_keyframes",
       "maximum number of keyframes; the keyframe distance and angle grow to satisfy this limit",
       ZeroIs("no limit")},
      {"output", "folder or file for the results; created if missing"},
      {"pictures", "write images of the map and the trajectory"},
      {"readout_s", "readout time of a rolling shutter, from the top row to the bottom row",
       Between(0, 1), InUnit("s")},
      {"run", "output folder of surfit_slam"},
      {"seed", "seed of the random numbers"},
      {"sequence",
       "sequence to read: a folder, a .klg, .sens, .bag, .db3, .mcap or .oni file, the URI of a "
       "camera, or any for the first camera"},
      {"session", "session folder, in which surfit_slam saves the state of its runs"},
      {"source", "source cloud, which is transformed to the target: PLY or PCD, in m"},
      {"summary", "JSON file for all results and options; empty: none"},
      {"target", "target cloud: PLY or PCD, in m"},
      {"threads", "maximum number of threads that compute at the same time", Between(1, 1024)},
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

std::string PresentName(const std::string& name) {
  for (const RenamedOption& renamed : kRenamedOptions) {
    if (name == renamed.old_name) return renamed.name;
  }
  return name;
}

}  // namespace surfit
