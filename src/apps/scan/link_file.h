#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "io/files/places_file.h"

namespace surfit {

// Loop candidate: keyframes of two fragments, by frame index. The source is in the later fragment.
struct PlaceProposal {
  int source_frame = 0, target_frame = 0;
  double similarity = 0;
};

// Loop candidates between two fragments.
struct FragmentCandidates {
  std::string target, source;  // names of fragments
  std::vector<PlaceProposal> proposals;
};

// All functions throw InputError with the name of the file.
void WriteCandidates(const FragmentCandidates& pair, const std::string& path);
FragmentCandidates ReadCandidates(const std::string& path);

// Links between two fragments. ReadLinks() reads only the members that the graph needs: frames,
// reason, overlap, pose and information.
struct FragmentLinks {
  std::string target, source;
  std::vector<ScanLink> links;
};
void WriteLinks(const FragmentLinks& pair, const std::string& path);
FragmentLinks ReadLinks(const std::string& path);

// Keyframes of a fragment; std::nullopt if it has no places.bin.
std::optional<RunPlaces> PlacesOf(const std::string& scan, const ScanFragment& fragment,
                                  PlacesPart part);

}  // namespace surfit
