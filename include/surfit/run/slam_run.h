#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/io/sequence.h"
#include "surfit/slam/slam.h"

namespace surfit {

class OptionVisitor;

// Options of a run: input, output and SLAM.
struct SlamRunOptions {
  SequenceOptions sequence;
  SlamOptions slam;
  std::string output;  // output folder; created if missing
  // Ground-truth trajectory in TUM format, in the convention of the files. "device": the poses that
  // the phone has estimated, for a comparison. Empty: that of the sequence, if it has one.
  std::string groundtruth;
  bool fit_mount = false;  // estimates SlamRunSummary::mount; requires ground truth
  // Trajectory of another source, read as `groundtruth`: see Slam::UsePriorPoses(). Empty: none.
  std::string prior_poses;
  // Pose world_from_camera of the first frame: identity, groundtruth or tx,ty,tz,qx,qy,qz,qw (m,
  // unit quaternion).
  std::string initial_pose = "identity";
  // track, or groundtruth: fuse at the ground-truth poses without tracking, other frames are lost.
  // Must be track with loop closure.
  std::string poses = "track";
  int threads = 2;         // maximum number of computing threads
  int queue_capacity = 8;  // maximum number of queued input frames
  // Replays a recording at this rate, 1/s, like a camera (OfferFrames()). This shows if the run is
  // fast enough. Sets `slam.real_time`, and `slam.confident_inlier_ratio` to 0. 0: as fast as
  // possible.
  double offered_fps = 0;
  // Steps after the last frame, which read the sequence again. `refine`: if the calibration has
  // changed, refines it jointly with the poses, and registers all frames with colour to the final
  // map. `final_map`: fuses the map again with the final poses and calibration. `refine` has no
  // effect without `final_map`. Both have no effect for live sources (IsLive()), continued
  // sessions, localisation, and after an early end.
  bool refine = true;
  bool final_map = true;
  // Adds surfaces that only colour images show to the final map: see FindUnmeasuredSurfaces().
  bool stereo = true;
  // Writes pictures of the map and of the trajectory.
  bool pictures = true;
  // World frame of pictures and report. "upright": z is up and the floor is at z = 0, if
  // SlamRunSummary::gravity is known. "run": the world frame of the map.
  std::string world = "upright";
  bool keep_views = false;   // saves some frames with their model views, for WriteReport()
  bool keep_places = false;  // writes places.bin (RunPlaces), which connects this run to other runs
  // Session folder: the run saves its state there continuously. Enables loop closure. The folder
  // must not have a session, except with one of the next two options. Empty: none.
  std::string session;
  // Continues an existing session. The camera is relocalised, or tracked from the last pose if the
  // recording follows within 1 s. If the session already has frames of this recording, the run
  // starts after the last such frame. LoopOptions::new_map_after is 10 instead of 0. Without a
  // session in the folder, a new session begins.
  bool continue_session = false;
  // Localises the camera in an existing session, which does not change.
  bool localize = false;
  std::string trace;  // file for a trace of all stages (TraceRecorder); empty: none
  // Folder for failed registrations (frame-XXXXXX), the input of CompareOptions::replay. Empty:
  // none.
  std::string dump_failures;

  // True if frames arrive at a fixed rate. Late frames are then dropped. RunSlam() then sets
  // `slam.real_time`, and `slam.confident_inlier_ratio` to 0.
  bool OffersFrames() const { return offered_fps > 0 || sequence.format == "openni2"; }

  void Visit(OptionVisitor& visitor);
};

// Processed frame with its outcome. References are valid during the callback only.
struct SlamRunFrame {
  const RgbdFrame& frame;
  const FrameReport& report;
  const SurfelMap& map;
  DepthSensor sensor;
  const Backend* backend = nullptr;  // null without loops and calibration
  // Time since the frame arrived, ms. 0 if frames do not arrive at a fixed rate.
  double age_ms = 0;
};

// Progress of a run.
struct SlamRunProgress {
  int frames_done = 0;
  int frames_total = 0;  // number of frames; -1: unknown
  std::size_t map_points = 0;
  double elapsed_s = 0;
  int refinement_rounds = 0;            // completed rounds of the final refinement
  int frames_reintegrated = 0;          // frames fused into the final map
  const SlamRunFrame* frame = nullptr;  // last frame; null if unreadable, and after all frames
};

// Result in the world of the frames: mirrored if SequenceInfo::mirrored is true, unlike the files.
// References are valid during the callback only.
struct SlamRunResult {
  const SurfelMap& map;
  const Trajectory& trajectory;
};

// Statistics of times. Use the mean as cost per frame, because the work varies periodically.
struct TimeStatistics {
  double mean_ms = 0;
  double median_ms = 0;
  double p95_ms = 0;
};

// Times of one stage over all frames.
struct StageStatistics {
  std::string name;
  TimeStatistics times;
  double share = 0;  // ratio to the total time
};

// Refinement after the last frame.
struct FinalRefinement {
  CalibrationRecord record;
  // Decrease of the squared residuals of held-out keyframes, in units of their variance, compared
  // with the calibration of the run. 0 without a new calibration.
  double held_out_gain = 0;
  bool is_applied = false;  // false if poses and calibration of the run were kept
  double seconds = 0;
};

// Statistics of localisation in a session.
struct Localization {
  int frames = 0;             // frames with a pose
  int relocalisations = 0;    // relocalised frames, including the first frame
  double longest_loss_s = 0;  // longest time without a pose, except at the end
  // Median standard deviation in the least certain direction, from the registration covariance.
  double median_sigma_m = 0;
  double median_sigma_rad = 0;
};

// Direction of gravity in the world frame of a run, from horizontal planes and walls of the map.
struct Gravity {
  // World frame of the run to the upright frame: z is up, the floor is at z = 0, and the walls are
  // along x and y.
  Rigid3d upright_from_world;
  double sigma_rad = 0;  // standard deviation of the direction
};

// Piece of a trajectory. No loop closure connects it to another piece. Pieces are placed beside
// each other along x, so poses of different pieces are not comparable.
struct TrajectoryPiece {
  int first_frame = 0, last_frame = 0;             // indices of frames with a pose
  int frames = 0;                                  // frames with a pose
  std::optional<TrajectoryEvaluation> evaluation;  // with ground truth only
};

// Depth noise of a run (DepthNoise::inverse_depth_sigma), 1/m. If the noise of the first frames
// contradicts the starting value by more than a factor of 2.5, all stages use the measured noise,
// at least 0.001 1/m. An option is never replaced.
struct NoiseReport {
  double start = 0;  // of the camera file, the preset or the option
  // std::nullopt: too little motion, a live source, or frames that arrive at a fixed rate.
  std::optional<double> measured;
  double used = 0;
  bool is_applied = false;   // true: `used` is the measured noise
  int frames = 0;            // number of frames that were read for the measurement
  int pairs = 0;             // number of compared pairs of frames
  std::int64_t samples = 0;  // number of compared pixels
};

// Results of a run: the content of summary.json.
struct SlamRunSummary {
  int frames_total = 0;    // input frames, including unreadable frames
  int frames_tracked = 0;  // frames with a pose at their own time
  // Frames in trajectory.txt: tracked frames, and lost frames whose pose was found later.
  int frames_with_pose = 0;
  int frames_lost = 0;
  int frames_with_motion = 0;  // tracked frames with more than 10 % moving points
  int frames_confirmed = 0;    // lost frames whose pose the next frame has confirmed
  // Lost frames whose last tracked frame had more than 10 % moving points.
  int frames_lost_in_motion = 0;
  // Frames with FrameReport::has_two_motions, tracked or lost.
  int frames_with_two_motions = 0;
  int frames_degenerate = 0;  // see FrameState::kDegenerate
  int frames_fused = 0;
  // Indices of the frames that SlamOptions::hold_out has excluded from fusion.
  std::vector<int> held_out_frames;
  int frames_skipped = 0;  // frames with read errors
  // Frames that were dropped because the run was too slow. Not included in `frames_total`.
  int frames_dropped = 0;
  // Frames with a longer period than SlamOptions::map_period, because frames arrived too fast.
  int frames_with_longer_map_period = 0;
  int longest_map_period = 0;                   // 0 if frames do not arrive at a fixed rate
  int pauses = 0;                               // number of disconnections of the camera
  double paused_s = 0;                          // total time without camera
  BackendCounts loops;                          // 0 without loops and calibration
  std::vector<CalibrationRecord> calibrations;  // calibrations during tracking, in their order
  // std::nullopt without refinement or final map.
  std::optional<FinalRefinement> refinement;
  // Final calibration of the input frames. std::nullopt: input calibration.
  std::optional<DepthCalibration> calibration;
  // Warning if the calibration is implausible for the input sensor; empty: none.
  std::string calibration_warning;
  NoiseReport noise;
  double color_latency_s = 0;  // estimate, in addition to RgbdCamera::color_latency_s
  // Frames that were registered without photometric residuals for lack of colour or texture,
  // despite a positive photometric weight.
  int frames_without_intensities = 0;
  bool interrupted = false;
  std::string failure;                  // errors of the run or of output files; empty: none
  std::int64_t input_points = 0;        // pixels of all processed frames
  std::int64_t input_points_valid = 0;  // pixels with depth
  std::int64_t updated = 0, added = 0, removed = 0;  // surfels, summed over all frames
  std::int64_t refused = 0;                          // surfels not added because the map is full
  std::int64_t merged_duplicates = 0;                // duplicate surfels merged after loop closures
  std::size_t map_points = 0;
  double compression_ratio = 0;   // input_points / map_points
  double match_ratio_last = 0;    // merged points / valid points, last fused frame
  double match_ratio_median = 0;  // median over all fused frames
  // Sorted by their first frames. Empty if no frame has a pose.
  std::vector<TrajectoryPiece> pieces;
  // Evaluates the piece with the most frames; with ground truth only.
  std::optional<TrajectoryEvaluation> evaluation;
  double sensor_latency_s = 0;  // RgbdCamera::latency_s: file timestamp minus pose timestamp
  // ATE with the timestamps of the files, and ATE with a time offset fitted to the ground truth.
  std::optional<AbsoluteTrajectoryError> ate_without_latency;
  std::optional<TimeOffset> time_offset;
  std::optional<MountFit> mount;   // with SlamRunOptions::fit_mount and ground truth
  std::optional<Gravity> gravity;  // std::nullopt: unknown, see `gravity_unknown`
  std::string gravity_unknown;     // reason
  std::optional<ImuReport> imu;    // std::nullopt: no inertial sensor
  double total_s = 0;
  std::optional<double> final_map_s;  // duration of the final map fusion; std::nullopt without it
  // Time per frame between completions, without the wait for input.
  TimeStatistics frame;
  // Time from the arrival of a frame to its completion, and to its pose. 0 if frames do not arrive
  // at a fixed rate.
  TimeStatistics latency;
  TimeStatistics pose_latency;
  // read (parallel to other stages), preprocess, predict, track, fuse, correct, write.
  std::vector<StageStatistics> stages;
  std::int64_t peak_rss_bytes = 0;
  // False if fewer than half of the frames have a pose: the result is unreliable.
  bool MostFramesHaveAPose() const { return 2 * frames_tracked >= frames_total; }

  std::int64_t session_waits = 0;               // saves that waited for the previous save
  std::optional<PriorPoseSummary> prior_poses;  // with SlamRunOptions::prior_poses only
  std::optional<Localization> localization;     // for localisation only

  // Digest of the final trajectory and of the map before final fusion. Equal digests mean bitwise
  // identical results.
  std::string digest;
};

// Runs SLAM on a sequence and writes these files into the output folder:
//   trajectory.txt         TUM format, final poses in the convention of the source
//   trajectory_online.txt  poses as estimated online, without later corrections
//   frames.csv, map.ply, summary.json, poses.json, pictures
//   loops.csv              with loop closure
//   camera.yaml            if the calibration, the colour latency or the noise has changed
//   localization.csv       for localisation in a session
//   report files, places.bin    by the options
//
// With a continued session, frame indices, poses and the map are those of the session. Frames that
// the session already has are skipped. A sequence of the format watch runs until its end
// (WatchFolder()). Unreadable frames are skipped and counted.
//
// `progress` must not be empty. It is called on the calling thread after every frame and refinement
// round, and for every frame of the final map. Frame times exclude it. Its exceptions end the run.
// If `interrupted` becomes true, the current frame is completed and all results are written. A run
// over a recording has at least one frame. `finished`, if not empty, is called on the calling
// thread after success only.
//
// Throws InputError for invalid options, for an output folder that another run is writing to, and
// if no frame can be read. Later errors (out of memory, full disk, read error) end the run: all
// possible results are written, then InputError is thrown.
SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress,
                       const std::function<void(const SlamRunResult&)>& finished = {});

// Reads the flags of a run by name from its summary.json. Throws InputError with the path of an
// unreadable or invalid file.
std::map<std::string, std::string> RecordedFlags(const std::string& summary_json);

}  // namespace surfit
