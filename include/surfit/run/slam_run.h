#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/sequence.h"
#include "surfit/slam/slam.h"

namespace surfit {

class OptionVisitor;

// What a run is to do, beyond how the SLAM works.
struct SlamRunOptions {
  SequenceOptions sequence;
  SlamOptions slam;
  std::string output;  // folder for all results; made if missing
  // Ground truth trajectory instead of the sequence's. TUM format. Empty: the sequence's.
  std::string groundtruth;
  bool fit_mount = false;                 // SlamRunSummary::mount
  std::string initial_pose = "identity";  // identity, groundtruth or tx,ty,tz,qx,qy,qz,qw
  std::string poses = "track";            // track, or groundtruth: fuse along the given poses
  int threads = 2;                        // that compute at the same time
  int queue_capacity = 8;                 // frames that are read ahead, or offered and kept
  // Frames are offered at this rate, as a camera does (OfferFrames()), which shows whether they can
  // all be taken in time, and only lost ones are looked for from afar (slam.sure_inlier_share is
  // taken as 0); 0 = as fast as they are processed.
  double offered_fps = 0;
  // In the end the sequence is read once more. Where the camera was found to be another one than
  // given, it is refined jointly with the poses; where it is right as given, tracking has seen more
  // than keyframes tell. Then the map is fused anew, along the final poses and by the calibration
  // that was found. Neither is done where frames are live (IsLive()), and nothing is refined
  // without a final map.
  bool refine = true;
  bool final_map = true;
  bool pictures = true;
  bool keep_views = false;   // pictures of a few frames beside the model's views, for WriteReport()
  bool keep_places = false;  // places.bin (RunPlaces), to be joined to other runs
  // Folder of the session (Session) that the run keeps as it goes; empty = none. Loops are then
  // closed. A new one is made, or else,
  std::string session;
  bool continue_session = false;  // the run goes on in it: where it has ended, or anywhere in it
  // or finds the camera in it, and leaves the session and its map as they are.
  bool localize = false;
  std::string trace;  // file for the times of all stages and threads (TraceRecorder); empty = none
  // Folder in which each frame that tracking loses is kept as frame-XXXXXX, to be registered again
  // (CompareOptions::replay); empty = none.
  std::string dump_failures;

  // Whether frames come at a rate of their own, so that those not taken in time are dropped.
  bool OffersFrames() const { return offered_fps > 0 || sequence.format == "openni2"; }

  void Visit(OptionVisitor& visitor);
};

// A frame that has just been processed, and what it made of the map, for those who watch. What it
// refers to is gone after the call that is given it.
struct SlamRunFrame {
  const RgbdFrame& frame;
  const FrameReport& report;
  const SurfelMap& map;
  DepthSensor sensor;                // of the frame
  const Backend* backend = nullptr;  // that closes loops; null where there is none
  // Since it was offered, or came from a camera; 0 where frames wait for the run.
  double age_ms = 0;
};

// How far a run has come.
struct SlamRunProgress {
  int frames_done = 0;
  int frames_total = 0;  // -1: as many as will come
  std::size_t map_points = 0;
  double elapsed_s = 0;
  int refinement_rounds = 0;            // in the end
  int frames_fused_anew = 0;            // of the final map
  const SlamRunFrame* frame = nullptr;  // of the last frame, unless that could not be read
};

// What a run has come to, for those who watch: map and trajectory as they are written. What it
// refers to is gone after the call that is given it.
struct SlamRunResult {
  const SurfelMap& map;
  const Trajectory& trajectory;
};

// The mean, the median and the 95 % quantile of some times. Frames take turns in what they do: the
// mean tells what a stage costs a frame.
struct TimeStatistics {
  double mean_ms = 0;
  double median_ms = 0;
  double p95_ms = 0;
};

// The times of one stage of all frames.
struct StageStatistics {
  std::string name;
  TimeStatistics times;
  double share = 0;  // of the time of all frames
};

// How poses and calibration were refined in the end.
struct FinalRefinement {
  CalibrationRecord record;
  double seconds = 0;
};

// How well a camera was found in a session, without that being changed.
struct Localization {
  int frames = 0;               // with a pose
  int relocalisations = 0;      // by a place; the first included
  double longest_loss_s = 0;    // from a frame without a pose to the next with one
  double median_sigma_m = 0;    // standard deviation of a position, as registrations tell
  double median_sigma_rad = 0;  // and of a turn
};

// The outcome of a run: what summary.json says.
struct SlamRunSummary {
  int frames_total = 0;    // read or attempted
  int frames_tracked = 0;  // with a pose: all but lost and skipped ones
  int frames_lost = 0;
  int frames_with_motion = 0;  // tracked ones, of whose points more than a tenth move by themselves
  int frames_confirmed = 0;    // of those lost, the ones that the next frame has given a pose
  int frames_lost_in_motion = 0;  // lost ones, where such a one is the last that was tracked
  int frames_apart = 0;  // of whose views parts move apart (FrameReport::is_apart), lost or not
  int frames_fused = 0;  // into the map, of the tracked ones
  std::vector<int> held_out_frames;  // indices of tracked ones that SlamOptions::hold_out left out
  int frames_skipped = 0;            // could not be read
  int frames_dropped = 0;            // offered, but not taken in time: not in frames_total
  // While these came, offered too fast, fewer were fused than SlamOptions::map_period says.
  int frames_hurried = 0;
  int longest_map_period = 0;  // at the worst, one of so many; 0 where none are offered
  int pauses = 0;              // that a camera was unplugged, and came back
  double paused_s = 0;         // in all
  BackendCounts loops;         // all zero without loops and calibration
  std::vector<CalibrationRecord> calibrations;  // of the depth camera, in their order
  std::optional<FinalRefinement> refinement;    // none where the camera is as given, or not refined
  // Of the frames as they were given; the last that was found, or none where they are right.
  std::optional<DepthCalibration> calibration;
  std::string calibration_doubt;  // a sentence where that is hardly the sensor that was given
  double color_latency_s = 0;     // that was found beyond the given one
  // Tracked by their shapes alone though intensities were asked for, for want of colour or texture.
  int frames_without_intensities = 0;
  bool interrupted = false;
  std::string failure;                  // what has ended the run early, or was not written
  std::int64_t input_points = 0;        // pixels after downsampling, of all frames read
  std::int64_t input_points_valid = 0;  // of those, with depth
  std::int64_t updated = 0, added = 0, removed = 0;  // surfels, summed over all frames
  std::int64_t refused = 0;                          // and these for want of place in the map
  std::int64_t merged_doubles = 0;                   // and those that loops put on others
  std::size_t map_points = 0;
  double compression_ratio = 0;   // input_points / map_points
  double match_share_last = 0;    // merged over valid points, of the last fused frame
  double match_share_median = 0;  // over all fused frames
  std::optional<TrajectoryEvaluation> evaluation;  // where there is ground truth
  double sensor_latency_s = 0;  // that poses are earlier than the files' stamps: RgbdCamera
  // Beside the evaluation: the error if poses had the files' stamps; and with an offset of all
  // stamps that is fitted to the truth.
  std::optional<AbsoluteTrajectoryError> ate_without_latency;
  std::optional<TimeOffset> time_offset;
  std::optional<MountFit> mount;  // with SlamRunOptions::fit_mount and ground truth
  double total_s = 0;
  std::optional<double> final_map_s;  // that fusing the map anew took; none where it was not
  TimeStatistics frame;    // between the completions of consecutive frames, less the time waited
  TimeStatistics latency;  // from a frame being offered to its completion; 0 where none is
  TimeStatistics pose_latency;  // to its pose being known
  // decode (which reads ahead, beside the others), preprocess, predict, track, fuse, correct,
  // write.
  std::vector<StageStatistics> stages;
  std::int64_t peak_rss_bytes = 0;
  // Where fewer have one, what there is is in doubt.
  bool MostFramesHaveAPose() const { return 2 * frames_tracked >= frames_total; }

  std::int64_t session_waits = 0;  // saves of a session that were due before the last was written
  std::optional<Localization> localization;  // where the camera was localised in a session

  // Of trajectory and map, before that is fused anew: equal digests, equal results bit for bit.
  std::string digest;
};

// Runs SLAM over a sequence and writes into the output folder: trajectory.txt (TUM format, in the
// source's convention; as corrected in the end by loops, calibration and refinement),
// trajectory_online.txt (as each pose was at its time), frames.csv, loops.csv, map.ply,
// summary.json, poses.json, views/ and the pictures; where the depth camera was found to be another
// one than given, camera.yaml; where it was localised in a session, localization.csv. With a
// session that is gone on in, frames have the session's indices, poses and map are the session's,
// and nothing is refined or fused anew in the end; of a recording that the session has, what it has
// is passed over. A sequence of format watch is followed until its end (WatchFolder()). Frames that
// cannot be read are skipped and counted. When `interrupted` becomes true the frame at work, or
// else the first one, is finished and everything is written. `progress` is called after every
// frame, after every round of refinement and for every frame of the final map; its time is none of
// the frames'. What goes wrong once a frame was processed (no memory is left, the disk is full, the
// sequence cannot be read on) ends the run, too: what there is is written as far as it can be, and
// told. Throws InputError then, and for bad options, an output folder that another run is writing
// into, or a sequence that cannot be read at all. `finished` is called, if given, when all is
// written.
SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress,
                       const std::function<void(const SlamRunResult&)>& finished = {});

// The flags that a run was given, by name, as its summary.json has them. Throws InputError naming
// the file if it cannot be read or is no such file.
std::map<std::string, std::string> RecordedFlags(const std::string& summary_json);

}  // namespace surfit
