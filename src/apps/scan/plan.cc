#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "apps/scan/job_files.h"
#include "apps/scan/scan_plan.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

std::string NameOf(std::int64_t fragment) {
  std::array<char, 24> name;
  std::snprintf(name.data(), name.size(), "%04d", static_cast<int>(fragment));
  return name.data();
}

SlamRunOptions RunOfFragments(SlamRunOptions run) {
  run.slam.loops.enabled = run.keep_places = true;
  run.slam.loops.new_map_after = 0;  // a fragment has one world frame
  run.slam.calibration.enabled = run.refine = run.final_map = run.pictures = false;
  return run;
}

SlamRunOptions CameraRunOf(SlamRunOptions run, int frames) {
  SequenceOptions& sequence = run.sequence;
  const std::int64_t last = sequence.first + (frames - std::int64_t{1}) * sequence.stride;
  if (sequence.last < 0 || last < sequence.last) sequence.last = static_cast<int>(last);
  run.slam.loops.enabled = run.keep_places = false;
  // refine requires final_map.
  run.slam.calibration.enabled = run.refine = run.final_map = true;
  return run;
}

std::string FoundCamera(const std::string& scan, std::size_t recording) {
  return Concat(scan, "/camera/", recording, "/camera.yaml");
}

// Sets the camera file. Clears the camera options, because the file contains their values.
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
  ThrowIf(frame_count < 1, "the sequence has no frames");
  // Maximum number of frames per fragment, without the overlap with the next fragment.
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

namespace {

SequenceOptions OptionsOfRecording(const ScanPlan& plan, const std::string& path) {
  SequenceOptions sequence = plan.run.sequence;
  sequence.path = path;
  return WithAbsolutePaths(sequence);
}

std::vector<ScanFragment> CutRecordings(const ScanPlan& plan, const ScanPlanOptions& options) {
  std::vector<ScanFragment> all;
  for (std::size_t r = 0; r < plan.recordings.size(); ++r) {
    const SequenceOptions& sequence = plan.recordings[r];
    const int frames = OpenSequence(sequence)->info().frame_count;
    for (ScanFragment fragment :
         CutIntoFragments(sequence.first, frames, sequence.stride, options.fragment_frames,
                          options.overlap_frames)) {
      fragment.name = NameOf(static_cast<std::int64_t>(all.size()));
      fragment.recording = static_cast<int>(r);
      all.push_back(fragment);
    }
  }
  return all;
}

void WriteFlagFiles(const ScanPlan& plan, const std::string& scan) {
  CreateFolder(scan + "/fragments");
  for (const ScanFragment& fragment : plan.fragments) {
    SlamRunOptions run = plan.run;
    run.sequence = plan.recordings[fragment.recording];
    run.sequence.first = fragment.first;
    run.sequence.last = fragment.last;
    WriteIfChanged(FlagFileOf(run), Concat(scan, "/fragments/", fragment.name, ".flags"));
  }
  for (std::size_t r = 0; r < plan.recordings.size(); ++r) {
    SlamRunOptions run = plan.run;
    run.sequence = plan.recordings[r];
    if (plan.camera_frames > 0) {
      WriteIfChanged(FlagFileOf(CameraRunOf(run, plan.camera_frames)),
                     Concat(scan, "/camera_", r, ".flags"));
    }
    SlamRunOptions found = run;
    found.sequence = WithCamera(found.sequence, AbsolutePath(FoundCamera(scan, r)));
    WriteIfChanged(FlagFileOf(found, run), Concat(scan, "/found_camera_", r, ".flags"));
  }
}

Json ToJson(const ScanPlan& plan) {
  Json recordings = Json::array(), fragments = Json::array();
  for (const SequenceOptions& recording : plan.recordings) recordings.push_back(recording.path);
  for (const ScanFragment& fragment : plan.fragments) {
    fragments.push_back({{"name", fragment.name},
                         {"recording", fragment.recording},
                         {"first", fragment.first},
                         {"last", fragment.last}});
  }
  return {{"run", OptionsToJson(plan.run)}, {"camera_frames", plan.camera_frames},
          {"tile_m", plan.tile_m},          {"pictures", plan.pictures},
          {"recordings", recordings},       {"fragments", fragments}};
}

}  // namespace

ScanPlan PlanScan(const ScanPlanOptions& options) {
  Validate(options);
  ScanPlan plan;
  plan.run = RunOfFragments(options.run);
  plan.camera_frames = options.camera_frames;
  plan.tile_m = options.tile_m;
  plan.pictures = options.pictures;
  for (const std::string& path : options.sequences) {
    plan.recordings.push_back(OptionsOfRecording(plan, path));
  }
  plan.fragments = CutRecordings(plan, options);
  const std::string& scan = options.run.output;
  WriteFlagFiles(plan, scan);
  WriteIfChanged(ToJson(plan).dump(2, ' ', false, Json::error_handler_t::replace) + "\n",
                 scan + "/plan.json");
  return plan;
}

ScanPlan ReadScanPlan(const std::string& scan) {
  const std::string plan_json = scan + "/plan.json";
  const Json json = ReadJson(plan_json);
  ScanPlan plan;
  try {
    plan.run = OptionsFromJson<SlamRunOptions>(json.at("run"));
    json.at("camera_frames").get_to(plan.camera_frames);
    json.at("tile_m").get_to(plan.tile_m);
    json.at("pictures").get_to(plan.pictures);
    for (const Json& path : json.at("recordings")) {
      plan.recordings.push_back(OptionsOfRecording(plan, path));
    }
    for (const Json& fragment : json.at("fragments")) {
      plan.fragments.push_back({fragment.at("name"), fragment.at("first"), fragment.at("last"),
                                fragment.at("recording")});
      if (static_cast<std::size_t>(plan.fragments.back().recording) < plan.recordings.size()) {
        continue;
      }
      throw InputError(plan_json, ": fragment ", plan.fragments.back().name,
                       " refers to a recording that is not in the plan");
    }
  } catch (const Json::exception& error) {
    throw InputError(plan_json, ": invalid or incompatible scan plan (", error.what(),
                     "): create it again with surfit_scan --step=plan");
  }
  for (std::size_t r = 0; r < plan.recordings.size() && plan.camera_frames > 0; ++r) {
    const std::string camera = FoundCamera(scan, r);
    if (!std::filesystem::exists(camera)) continue;
    plan.recordings[r] = WithCamera(plan.recordings[r], camera);
  }
  return plan;
}

}  // namespace surfit
