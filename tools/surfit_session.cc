// Lists, checks, exports, merges and compacts sessions.

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "common/tool_main.h"
#include "core/shared_options.h"
#include "io/files/places_file.h"
#include "session/merge_sessions.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/session/session.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string command, session, output;
  std::vector<std::string> from;
  LoopOptions loops;

  void Visit(OptionVisitor& v) {
    v.Group("session");
    v.Add(command, "command",
          "command (first word or this flag); list: contents; check: find damage; export: "
          "trajectory.txt, run-N.txt, map.ply and places.bin; merge: other sessions into a new "
          "session; compact: reduce the size",
          OneOf({"list", "check", "export", "merge", "compact"}), Required(), Everyday());
    v.Add(session, SharedOption("session", Required(), Everyday()));
    v.Add(output, SharedOption("output", Everyday()));
    v.Add(from, "from", "session to merge; set once per session", Repeatable(), Everyday());
    v.AddPart(loops, "loops", "loop closure between sessions", NoFlags());
  }
};

// Size in MB, rounded.
std::string Size(std::int64_t bytes) { return Concat((bytes + 500000) / 1000000, " MB"); }

int List(const Options& options) {
  const SessionCounts c = CountSession(options.session);
  std::cout << options.session << ": " << c.frames << " frames with a pose, " << c.keyframes
            << " keyframes (" << c.views << " with views), " << c.edges << " edges (" << c.loops
            << " loops), " << c.submaps << (c.submaps == 1 ? " map" : " maps") << ", " << c.surfels
            << " surfels in " << c.tiles << " tiles, " << c.saves << " saves, " << Size(c.bytes)
            << '\n';
  int number = 0;
  for (const SessionRun& run : ReadSessionRuns(options.session)) {
    std::cout << "run " << ++number << ": " << run.sequence << " (" << run.format << ") from frame "
              << run.first << ", stride " << run.stride << ", as frame " << run.first + run.shift
              << " of the session" << (run.ended ? "" : ", not finished") << '\n';
  }
  return kDone;
}

int Check(const Options& options) {
  const std::vector<std::string> damages = CheckSession(options.session);
  for (const std::string& damage : damages) std::cerr << "damaged: " << damage << '\n';
  if (!damages.empty()) return kAlgorithmFailed;
  std::cout << options.session << ": no damage" << std::endl;
  return kDone;
}

// Run of a frame of the session.
std::size_t RunOf(const std::vector<SessionRun>& runs, int frame) {
  std::size_t run = 0;
  while (run + 1 < runs.size() && runs[run + 1].first + runs[run + 1].shift <= frame) ++run;
  return run;
}

int Export(const Options& options) {
  RequireFlag("output", options.output);
  const Session session = ReadSession(options.session);
  const SlamState& state = session.state;
  std::filesystem::create_directories(options.output);
  Trajectory all;
  std::vector<Trajectory> of_run(session.runs.size());
  for (const PosedFrame& frame : state.frames) {
    const std::size_t run = RunOf(session.runs, frame.index);
    const bool mirrored = run < session.runs.size() && session.runs[run].mirrored;
    const Rigid3d pose = mirrored ? Mirrored(frame.world_from_camera) : frame.world_from_camera;
    all.push_back({frame.stamp_s, pose});
    if (run < of_run.size()) of_run[run].push_back(all.back());
  }
  WriteTumTrajectory(all, options.output + "/trajectory.txt");
  for (std::size_t run = 0; run < of_run.size(); ++run) {
    WriteTumTrajectory(of_run[run], Concat(options.output, "/run-", run + 1, ".txt"));
  }
  WriteSurfelPly(state.map, options.output + "/map.ply");
  RunPlaces places = {state.frames, {}, state.edges};
  std::size_t frame = 0;
  for (std::size_t k = 0; k < state.keyframes.size(); ++k) {
    while (state.frames[frame].index != state.keyframes[k].frame) ++frame;
    const PosedFrame& posed = state.frames[frame];
    places.keyframes.push_back(
        {posed.index, posed.stamp_s, posed.world_from_camera, state.views[k]});
  }
  WritePlaces(places, options.output + "/places.bin");
  std::cout << options.output << ": " << all.size() << " poses of " << of_run.size() << " runs, "
            << state.map.size() << " surfels, " << places.keyframes.size() << " places"
            << std::endl;
  return kDone;
}

int Merge(const Options& options) {
  if (options.from.size() < 2) {
    throw InputError(
        Concat("--from names ", options.from.size(), " sessions, must name two or more"));
  }
  SlamOptions slam;
  slam.loops = options.loops;
  const MergeSummary merged = MergeSessions(options.from, slam, options.session);
  std::cout << options.session << ": " << merged.sessions << " sessions, " << merged.frames
            << " frames, " << merged.keyframes << " keyframes, " << merged.loops_between
            << " loops between sessions, " << merged.surfels << " surfels ("
            << merged.merged_duplicates << " duplicates merged)" << std::endl;
  for (const std::string& apart : merged.apart) {
    std::cerr << "warning: " << apart
              << " has no loop closure to the first session: it stays a separate map\n";
  }
  return merged.apart.empty() ? kDone : kAlgorithmFailed;
}

int Compact(const Options& options) {
  const std::int64_t before = CountSession(options.session).bytes;
  CompactSession(options.session);
  std::cout << options.session << ": " << Size(before) << " before, "
            << Size(CountSession(options.session).bytes) << " now" << std::endl;
  return kDone;
}

int Run(const Options& options) {
  if (options.command == "list") return List(options);
  if (options.command == "check") return Check(options);
  if (options.command == "export") return Export(options);
  return options.command == "merge" ? Merge(options) : Compact(options);
}

// A first word without dash is the value of --command.
int Main(int argc, char** argv) {
  std::vector<std::string> words(argv, argv + argc);
  if (argc > 1 && words[1].rfind('-', 0) != 0) words[1] = "--command=" + words[1];
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return ToolMain(argc, pointers.data(),
                  "lists, checks, exports, merges and compacts sessions of surfit_slam", Run);
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) { return surfit::tools::Main(argc, argv); }
