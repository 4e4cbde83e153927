#include "io/bags/bag_imu.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include "io/bags/messages.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// An accelerometer sample is interpolated if its neighbours are at most this far apart.
constexpr double kMaxAccelGap_s = 0.1;

std::vector<ImuSample> ReadImuTopic(const MessageLog& log, const Topic& topic) {
  const std::string name = Concat(log.path(), ": ", topic.name);
  std::vector<ImuSample> samples;
  samples.reserve(topic.messages.size());
  for (const MessageLocation& place : topic.messages) {
    const ImuMessage message = ReadImuMessage(log.Read(place), topic, name);
    samples.push_back({static_cast<double>(message.header.stamp_ns) * 1e-9, message.gyro_rad_per_s,
                       message.accel_m_per_s2});
  }
  return samples;
}

bool NameHas(const Topic& topic, const std::string& word) {
  std::string name = topic.name;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.find(word) != std::string::npos;
}

// Topic with the word in its name. Null if there is none or several.
const Topic* OnlyWith(const std::vector<const Topic*>& topics, const std::string& word) {
  const Topic* found = nullptr;
  for (const Topic* topic : topics) {
    if (!NameHas(*topic, word)) continue;
    if (found != nullptr) return nullptr;
    found = topic;
  }
  return found;
}

bool IsEarlierSample(const ImuSample& a, const ImuSample& b) { return a.stamp_s < b.stamp_s; }

// Samples at the times of the gyroscope. Times without an accelerometer nearby are dropped.
std::vector<ImuSample> Combined(const std::vector<ImuSample>& gyro, std::vector<ImuSample> accel) {
  std::stable_sort(accel.begin(), accel.end(), IsEarlierSample);
  std::vector<ImuSample> both;
  for (const ImuSample& sample : gyro) {
    const auto next = std::lower_bound(accel.begin(), accel.end(), sample, IsEarlierSample);
    if (next == accel.end()) continue;
    const bool is_same = next->stamp_s == sample.stamp_s;
    if (!is_same &&
        (next == accel.begin() || next->stamp_s - std::prev(next)->stamp_s > kMaxAccelGap_s)) {
      continue;
    }
    both.push_back(sample);
    both.back().accel_m_per_s2 = InterpolateImu(accel, sample.stamp_s, 0)->accel_m_per_s2;
  }
  return both;
}

}  // namespace

std::optional<ImuRecording> ReadBagImu(const std::string& path, const std::string& format,
                                       bool is_folder) {
  const std::unique_ptr<MessageLog> log = OpenLog(path, format, is_folder);
  std::vector<const Topic*> topics;
  std::string names;
  for (const Topic& topic : log->topics()) {
    if (topic.type != "sensor_msgs/Imu" || topic.messages.empty() ||
        topic.serialization == Serialization::kOther) {
      continue;
    }
    topics.push_back(&topic);
    names += (names.empty() ? "" : ", ") + topic.name;
  }
  if (topics.empty()) return std::nullopt;
  ImuRecording imu;
  imu.read_from = Concat(path, ": ", names);
  if (topics.size() == 1) {
    imu.samples = ReadImuTopic(*log, *topics[0]);
    return imu;
  }
  const Topic* const gyro = OnlyWith(topics, "gyro");
  const Topic* const accel = OnlyWith(topics, "accel");
  ThrowIf(topics.size() != 2 || gyro == nullptr || accel == nullptr || gyro == accel, path,
          " has the Imu topics ", names,
          ", must have one, or one with 'gyro' and one with 'accel' in their names: set imu to "
          "false, or remove topics");
  const std::vector<ImuSample> rates = ReadImuTopic(*log, *gyro);
  imu.samples = Combined(rates, ReadImuTopic(*log, *accel));
  imu.dropped_samples = static_cast<int>(rates.size() - imu.samples.size());
  return imu;
}

}  // namespace surfit
