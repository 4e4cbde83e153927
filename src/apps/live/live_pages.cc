#include "apps/live/live_pages.h"

#include <algorithm>
#include <chrono>
#include <map>

#include "browser/page.h"

namespace surfit {
namespace {

HttpAnswer Bare(int status) {
  HttpAnswer answer;
  answer.status = status;
  return answer;
}

// Status 204 if there is no data yet.
HttpAnswer Found(const std::string& type, LiveData::Text body) {
  if (!body) return Bare(204);
  return {200, type, std::move(body), false};
}

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

LiveData::Text PageText() {
  static const LiveData::Text text =
      std::make_shared<std::string>(std::string(kLivePage.before_data) + kLivePage.after_data);
  return text;
}

const char* const kJson = "application/json";

}  // namespace

std::optional<HttpAnswer> LivePages::Answer(const HttpRequest& request, bool must) {
  const std::optional<HttpTarget> target = ParseTarget(request.target);
  const bool may = IsOwnHost(request.host) &&
                   (!request.origin || IsOwnOrigin(*request.origin, request.host)) && target &&
                   IsSameSecret(target->token, token_);
  if (!may) return Bare(403);
  std::optional<HttpAnswer> answer;
  if (request.method == "GET") {
    answer = Get(target->page, *target, must);
  } else {
    answer = request.method == "POST" ? Post(target->page) : Bare(405);
  }
  if (!answer) return std::nullopt;
  answer->has_token = true;
  answered_at_s_ = Now_s();
  return answer;
}

double LivePages::SinceLastAnswer_s() const { return Now_s() - answered_at_s_; }

std::optional<HttpAnswer> LivePages::Get(const std::string& page, const HttpTarget& target,
                                         bool must) {
  static const std::map<std::string, Shown> kPictures = {
      {"frame.jpg", Shown::kFrame}, {"model.jpg", Shown::kModel}, {"normals.jpg", Shown::kNormals}};
  if (page.empty()) return Found("text/html; charset=utf-8", PageText());
  if (page == "state") {
    shown_.RecordRequest(Shown::kState);
    for (std::size_t i = 0; i < kShownCount; ++i) {
      if ((target.Number("want") >> i & 1) != 0) shown_.RecordRequest(static_cast<Shown>(i));
    }
    LiveData::Text state = shown_.StateAfter(must ? 0 : target.Number("after"), run_.is_paused());
    if (!state && !must) return std::nullopt;
    return Found(kJson, std::move(state));
  }
  if (page == "map") return Map(target, must);
  if (page == "path") {
    shown_.RecordRequest(Shown::kPath);
    return Found(kJson, shown_.Path());
  }
  const auto picture = kPictures.find(page);
  if (picture == kPictures.end()) return Bare(404);
  shown_.RecordRequest(picture->second);
  return Found("image/jpeg", shown_.Picture(picture->second, target.Number("number")));
}

// Returns map data. All clients together get at most kBytesPerSecond.
std::optional<HttpAnswer> LivePages::Map(const HttpTarget& target, bool must) {
  constexpr double kBytesPerSecond = 16e6;
  constexpr std::size_t kMost = 16384;  // surfels per answer, 20 bytes each
  shown_.RecordRequest(Shown::kMap);
  const double now_s = Now_s();
  map_bytes_ = std::min(map_bytes_ + kBytesPerSecond * (now_s - map_bytes_at_s_), kBytesPerSecond);
  map_bytes_at_s_ = now_s;
  if (map_bytes_ <= 0 && !must) return std::nullopt;
  const SamplePlace place = {target.Number("epoch"), target.Number("level"), target.Number("since"),
                             target.Number("slot")};
  LiveData::Text changes = shown_.Map(place, kMost);
  map_bytes_ -= static_cast<double>(changes->size());
  return Found("application/octet-stream", std::move(changes));
}

HttpAnswer LivePages::Post(const std::string& page) {
  if (page == "pause") {
    run_.Pause();
  } else if (page == "go_on") {
    run_.GoOn();
  } else if (page == "step") {
    run_.Step();
  } else if (page == "stop") {
    run_.Stop();
  } else {
    return Bare(404);
  }
  shown_.MarkChanged();
  return Found(kJson, std::make_shared<std::string>("{}"));
}

}  // namespace surfit
