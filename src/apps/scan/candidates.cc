#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "apps/scan/job_files.h"
#include "apps/scan/link_file.h"
#include "apps/scan/scan_jobs.h"
#include "io/files/output_folder.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit {
namespace {

constexpr int kMinGap = 100;    // minimum frame index difference within a recording
constexpr int kMaxSimilar = 3;  // maximum number of candidates per keyframe
// Memory limit of the place index. If all keyframes exceed it, every n-th keyframe is used.
constexpr std::size_t kMaxIndexBytes = std::size_t{500} << 20;

struct Place {
  int fragment = 0;  // index in the plan
  int recording = 0;
  int frame = 0;
  PlaceView view;  // features only
};

class CandidateSearch {
 public:
  CandidateSearch(const CandidatesOptions& options, const ScanPlan& plan)
      : options_(options), plan_(plan), index_(plan.run.slam.loops.places) {}

  CandidatesResult Run() {
    const int step = StepWithinMemory();
    for (int i = 0; i < result_.fragments; ++i) ReadFragment(i, step);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      index_.Add(static_cast<int>(p), places_[p].view);
    }
    for (std::size_t p = 0; p < places_.size(); ++p) Propose(static_cast<int>(p));
    Write();
    result_.pairs = static_cast<int>(pairs_.size());
    return result_;
  }

 private:
  // Returns the smallest n for which the index of every n-th keyframe fits into kMaxIndexBytes.
  int StepWithinMemory() {
    std::size_t bytes = 0;
    for (const ScanFragment& fragment : plan_.fragments) {
      ++result_.fragments;
      const auto places = PlacesOf(options_.scan, fragment, PlacesPart::kFeatures);
      result_.missing += !places;
      if (!places) continue;
      result_.keyframes += static_cast<int>(places->keyframes.size());
      for (const Keyframe& keyframe : places->keyframes) bytes += BytesOf(keyframe.view);
    }
    return static_cast<int>(bytes / kMaxIndexBytes) + 1;
  }

  std::size_t BytesOf(const PlaceView& view) const {
    constexpr std::size_t entry =
        sizeof(BinaryDescriptor) + sizeof(int) + PlaceIndex::kTables * sizeof(std::uint32_t);
    return view.features.size() * (sizeof(PlaceFeature) + entry);
  }

  void ReadFragment(int fragment, int step) {
    auto places = PlacesOf(options_.scan, plan_.fragments[fragment], PlacesPart::kFeatures);
    if (!places) return;
    for (std::size_t k = 0; k < places->keyframes.size(); k += step) {
      Keyframe& keyframe = places->keyframes[k];
      places_.push_back({fragment, plan_.fragments[fragment].recording, keyframe.frame_index,
                         std::move(keyframe.view)});
      ++result_.looked_up;
    }
  }

  // Adds candidate pairs of keyframe `source` with similar earlier keyframes.
  void Propose(int source) {
    const Place& from = places_[source];
    const auto found = index_.Query(from.view, kMaxSimilar, [&](int p) {
      const Place& to = places_[p];
      return to.fragment < from.fragment &&
             (to.recording < from.recording || from.frame - to.frame >= kMinGap);
    });
    for (const PlaceCandidate& candidate : found) {
      const Place& to = places_[candidate.keyframe];
      pairs_[{to.fragment, from.fragment}].push_back({from.frame, to.frame, candidate.similarity});
    }
  }

  // Writes one file per fragment pair. Deletes files of earlier searches, because the next jobs
  // would use them.
  void Write() const {
    CreateFolder(options_.output);
    std::set<std::string> written;
    for (const auto& [fragments, proposals] : pairs_) {
      const std::string& target = plan_.fragments[fragments.first].name;
      const std::string& source = plan_.fragments[fragments.second].name;
      const std::string path = Concat(options_.output, "/", target, "_", source, ".json");
      WriteCandidates({target, source, proposals}, path);
      written.insert(path);
    }
    for (const std::string& former : FilesIn(options_.output, ".json")) {
      if (written.count(former) == 0) std::filesystem::remove(former);
    }
  }

  const CandidatesOptions& options_;
  const ScanPlan& plan_;
  CandidatesResult result_;
  std::vector<Place> places_;
  PlaceIndex index_;
  std::map<std::pair<int, int>, std::vector<PlaceProposal>> pairs_;  // key: target and source
};

}  // namespace

CandidatesResult FindCandidates(const CandidatesOptions& options) {
  Validate(options);
  const ScanPlan plan = ReadScanPlan(options.scan);
  return CandidateSearch(options, plan).Run();
}

}  // namespace surfit
