#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "io/files/places_file.h"

namespace surfit {

// Loop candidate: keyframes of two fragments. The source is in the later fragment of the plan.
struct PlaceProposal {
  int source_frame = 0, target_frame = 0;  // frame indices in the sequences of both recordings
  double similarity = 0;                   // PlaceCandidate::similarity
};

// Loop candidates between two fragments.
struct FragmentCandidates {
  std::string target, source;  // names of fragments
  std::vector<PlaceProposal> proposals;
};

// The files are JSON, written atomically. WriteCandidates() does not touch an unchanged file. All
// functions of this header throw InputError with the name of a file that cannot be read or written,
// or that is invalid.
void WriteCandidates(const FragmentCandidates& pair, const std::string& path);
FragmentCandidates ReadCandidates(const std::string& path);

// Links between two fragments. ReadLinks() reads only a part of each link: source_frame,
// target_frame, `reason` and `overlap_ratio` of the verdict, and for accepted links
// `target_from_source` and `information`. Other members have their default values.
struct FragmentLinks {
  std::string target, source;
  std::vector<ScanLink> links;
};
void WriteLinks(const FragmentLinks& pair, const std::string& path);
FragmentLinks ReadLinks(const std::string& path);

// Reads the poses, keyframes and pose graph of a fragment. `scan` is the folder of the scan.
// Returns std::nullopt if the fragment has no places.bin, because its run has failed.
std::optional<RunPlaces> PlacesOf(const std::string& scan, const ScanFragment& fragment,
                                  PlacesPart part);

}  // namespace surfit
