#include "apps/scan/link_file.h"

#include <algorithm>
#include <filesystem>

#include "apps/scan/job_files.h"
#include "output/output_files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

Rigid3d PoseFrom(const Json& json) {
  const auto n = json.get<std::array<double, 7>>();
  return {Eigen::Quaterniond(n[6], n[3], n[4], n[5]).normalized(), {n[0], n[1], n[2]}};
}

GlobalRegistrationReason ReasonFrom(const std::string& name) {
  for (const GlobalRegistrationReason reason : GlobalRegistrationReasons()) {
    if (ToString(reason) == name) return reason;
  }
  throw InputError("reason is '", name, "', must be a verification result");
}

template <typename Read>
void ReadPair(const std::string& path, const Read& read) {
  const Json json = ReadJson(path);
  try {
    read(json);
  } catch (const Json::exception& error) {
    throw InputError(path, ": invalid fragment pair: ", error.what());
  } catch (const InputError& error) {
    throw InputError(path, ": ", error.what());
  }
}

}  // namespace

void WriteCandidates(const FragmentCandidates& pair, const std::string& path) {
  Json proposals = Json::array();
  for (const PlaceProposal& proposal : pair.proposals) {
    proposals.push_back({proposal.source_frame, proposal.target_frame, proposal.similarity});
  }
  const Json json = {{"target", pair.target}, {"source", pair.source}, {"proposals", proposals}};
  WriteIfChanged(json.dump() + "\n", path);
}

FragmentCandidates ReadCandidates(const std::string& path) {
  FragmentCandidates pair;
  ReadPair(path, [&](const Json& json) {
    json.at("target").get_to(pair.target);
    json.at("source").get_to(pair.source);
    for (const Json& proposal : json.at("proposals")) {
      pair.proposals.push_back({proposal.at(0), proposal.at(1), proposal.at(2)});
    }
  });
  return pair;
}

void WriteLinks(const FragmentLinks& pair, const std::string& path) {
  Json links = Json::array();
  for (const ScanLink& link : pair.links) {
    const GlobalRegistrationResult& verdict = link.verdict;
    Json json = {{"source_frame", link.source_frame},
                 {"target_frame", link.target_frame},
                 {"reason", ToString(verdict.reason)},
                 {"agreeing_features", verdict.agreeing_features},
                 {"overlap_ratio", verdict.overlap_ratio},
                 {"inlier_ratio", verdict.inlier_ratio},
                 {"rmse_m", verdict.rmse_m}};
    if (verdict.accepted()) {
      json["target_from_source"] = ToJson(verdict.target_from_source);
      const auto numbers = verdict.information.reshaped();
      json["information"] = std::vector<double>(numbers.begin(), numbers.end());
    }
    links.push_back(std::move(json));
  }
  WriteJson({{"target", pair.target}, {"source", pair.source}, {"links", links}}, path, -1);
}

FragmentLinks ReadLinks(const std::string& path) {
  FragmentLinks pair;
  ReadPair(path, [&](const Json& json) {
    json.at("target").get_to(pair.target);
    json.at("source").get_to(pair.source);
    for (const Json& entry : json.at("links")) {
      ScanLink link = {entry.at("source_frame"), entry.at("target_frame"), {}};
      link.verdict.reason = ReasonFrom(entry.at("reason"));
      link.verdict.overlap_ratio = entry.at("overlap_ratio");
      if (link.verdict.accepted()) {
        link.verdict.target_from_source = PoseFrom(entry.at("target_from_source"));
        const auto numbers = entry.at("information").get<std::array<double, 36>>();
        std::copy(numbers.begin(), numbers.end(), link.verdict.information.data());
      }
      pair.links.push_back(link);
    }
  });
  return pair;
}

std::optional<RunPlaces> PlacesOf(const std::string& scan, const ScanFragment& fragment,
                                  PlacesPart part) {
  const std::string path = Concat(scan, "/fragments/", fragment.name, "/places.bin");
  if (!std::filesystem::exists(path)) return std::nullopt;
  return ReadPlaces(path, part);
}

}  // namespace surfit
