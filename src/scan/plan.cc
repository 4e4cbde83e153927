#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "run/job_files.h"
#include "run/output_files.h"
#include "run/output_folder.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/scan/scan_plan.h"

namespace surfit {
namespace {

std::string NameOf(std::int64_t fragment) {
  std::array<char, 24> name;
  std::snprintf(name.data(), name.size(), "%04d", static_cast<int>(fragment));
  return name.data();
}

// The fragment's part of the sequence, to be read and tracked from any working folder.
SlamRunOptions RunOf(SlamRunOptions run) {
  run.sequence = WithAbsolutePaths(run.sequence);
  run.slam.loops.enabled = run.keep_places = true;
  run.slam.calibration.enabled = run.refine = run.final_map = run.pictures = false;
  return run;
}

// How the camera is calibrated for all of them.
SlamRunOptions CameraRunOf(SlamRunOptions run, int frames) {
  SequenceOptions& sequence = run.sequence;
  const std::int64_t last = sequence.first + (frames - std::int64_t{1}) * sequence.stride;
  if (sequence.last < 0 || last < sequence.last) sequence.last = static_cast<int>(last);
  run.slam.loops.enabled = run.keep_places = false;
  // Poses and camera are refined where a final map is made.
  run.slam.calibration.enabled = run.refine = run.final_map = true;
  return run;
}

std::string FoundCamera(const std::string& scan) { return scan + "/camera/camera.yaml"; }

// The same sequence by another camera, of which that file says all.
SequenceOptions WithCamera(SequenceOptions sequence, const std::string& camera) {
  sequence.camera = camera;
  sequence.intrinsics = sequence.color_intrinsics = {};
  sequence.distortion = sequence.color_distortion = {};
  sequence.depth_units_per_metre = sequence.inverse_depth_sigma = {};
  sequence.color_from_depth = {};
  sequence.frames_per_second = sequence.latency_s = {};
  sequence.color_latency_s = sequence.readout_s = {};
  return sequence;
}

}  // namespace

std::vector<ScanFragment> CutIntoFragments(int first, int frame_count, int stride,
                                           int fragment_frames, int overlap_frames) {
  if (frame_count < 1) throw InputError("the sequence has no frame to be cut into fragments");
  // Without what it shares with the next, a fragment has so many frames at most.
  const std::int64_t step = fragment_frames - overlap_frames;
  const std::int64_t own = std::max(1, frame_count - overlap_frames);
  const std::int64_t count = (own + step - 1) / step;
  std::vector<ScanFragment> fragments;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t begin = i * own / count;
    const std::int64_t end =
        std::min<std::int64_t>(frame_count, (i + 1) * own / count + overlap_frames);
    fragments.push_back({NameOf(i), static_cast<int>(first + stride * begin),
                         static_cast<int>(first + stride * (end - 1))});
  }
  return fragments;
}

ScanPlan PlanScan(const ScanPlanOptions& options) {
  Validate(options);
  ScanPlan plan;
  plan.run = RunOf(options.run);
  plan.camera_frames = options.camera_frames;
  plan.tile_m = options.tile_m;
  const SequenceOptions& sequence = plan.run.sequence;
  plan.fragments =
      CutIntoFragments(sequence.first, OpenSequence(sequence)->info().frame_count, sequence.stride,
                       options.fragment_frames, options.overlap_frames);
  const std::string folder = options.run.output + "/fragments";
  MakeFolder(folder);
  Json fragments = Json::array();
  for (const ScanFragment& fragment : plan.fragments) {
    SlamRunOptions run = plan.run;
    run.sequence.first = fragment.first;
    run.sequence.last = fragment.last;
    WriteUnlessSame(FlagFileOf(run), Concat(folder, "/", fragment.name, ".flags"));
    fragments.push_back(
        {{"name", fragment.name}, {"first", fragment.first}, {"last", fragment.last}});
  }
  const std::string& scan = options.run.output;
  if (options.camera_frames > 0) {
    WriteUnlessSame(FlagFileOf(CameraRunOf(plan.run, options.camera_frames)),
                    scan + "/camera.flags");
  }
  SlamRunOptions found = plan.run;
  found.sequence = WithCamera(found.sequence, AbsolutePath(FoundCamera(scan)));
  WriteUnlessSame(FlagFileOf(found, plan.run), scan + "/found_camera.flags");
  const Json json = {{"run", OptionsToJson(plan.run)},
                     {"camera_frames", plan.camera_frames},
                     {"tile_m", plan.tile_m},
                     {"fragments", fragments}};
  WriteUnlessSame(json.dump(2) + "\n", scan + "/plan.json");
  return plan;
}

ScanPlan ReadScanPlan(const std::string& scan) {
  const std::string plan_json = scan + "/plan.json", camera = FoundCamera(scan);
  const Json json = ReadJson(plan_json);
  ScanPlan plan;
  try {
    plan.run = OptionsFromJson<SlamRunOptions>(json.at("run"));
    json.at("camera_frames").get_to(plan.camera_frames);
    json.at("tile_m").get_to(plan.tile_m);
    for (const Json& fragment : json.at("fragments")) {
      plan.fragments.push_back({fragment.at("name"), fragment.at("first"), fragment.at("last")});
    }
  } catch (const Json::exception& error) {
    throw InputError(Concat(plan_json, ": no plan of a scan: ", error.what()));
  }
  if (plan.camera_frames > 0 && std::filesystem::exists(camera)) {
    plan.run.sequence = WithCamera(plan.run.sequence, camera);
  }
  return plan;
}

}  // namespace surfit
