#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "io/files/places_file.h"

namespace surfit {

// Two keyframes that may show one place, by their frames' indices; source is of the later fragment.
struct PlaceProposal {
  int source_frame = 0, target_frame = 0;
  double similarity = 0;
};

// Two fragments that may have seen the same places.
struct PairCandidates {
  std::string target, source;  // names of fragments
  std::vector<PlaceProposal> proposals;
};

// All throw InputError naming the file.
void WriteCandidates(const PairCandidates& pair, const std::string& path);
PairCandidates ReadCandidates(const std::string& path);

// Links of which all the graph needs is read again: frames, reason, pose and information.
struct PairLinks {
  std::string target, source;
  std::vector<ScanLink> links;
};
void WriteLinks(const PairLinks& pair, const std::string& path);
PairLinks ReadLinks(const std::string& path);

// The places of a fragment; nothing if it has failed.
std::optional<RunPlaces> PlacesOf(const std::string& scan, const ScanFragment& fragment,
                                  PlacesPart part);

}  // namespace surfit
