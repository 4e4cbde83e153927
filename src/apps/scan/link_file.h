#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "io/files/places_file.h"

namespace surfit {

// Loop candidate: keyframes of two fragments. The source is in the later fragment.
struct PlaceProposal {
  int source_frame = 0, target_frame = 0;  // frame indices in the sequences
  double similarity = 0;                   // of the views, as in PlaceCandidate
};

// Loop candidates between two fragments.
struct FragmentCandidates {
  std::string target, source;  // fragment names
  std::vector<PlaceProposal> proposals;
};

// Files are JSON, written atomically. WriteCandidates() does not touch an unchanged file. All
// functions of this header throw InputError with the file name, for I/O errors and invalid
// files.
void WriteCandidates(const FragmentCandidates& pair, const std::string& path);
FragmentCandidates ReadCandidates(const std::string& path);

// ReadLinks() sets the frames, `reason` and `overlap_ratio` and, for accepted links,
// `target_from_source` and `information`. Other members have default values.
struct FragmentLinks {
  std::string target, source;
  std::vector<ScanLink> links;
};
void WriteLinks(const FragmentLinks& pair, const std::string& path);
FragmentLinks ReadLinks(const std::string& path);

// Reads places.bin of a fragment. Returns std::nullopt for a failed fragment, which has no such
// file.
std::optional<RunPlaces> PlacesOf(const std::string& scan, const ScanFragment& fragment,
                                  PlacesPart part);

}  // namespace surfit
