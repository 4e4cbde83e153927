#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace surfit {

// How messages are written: ROS 1's own way, or CDR (OMG's Common Data Representation), ROS 2's.
enum class Serialization { kRos1, kCdr, kOther };

// One message in the file, and its first bytes, as many as tell its stamp.
struct MessagePlace {
  std::int64_t recorded_ns = 0;
  int part = -1;         // the chunk that holds it, -1: the file itself
  std::uint64_t at = 0;  // its first byte in the part, or its row
  std::uint64_t size = 0;
  std::array<char, 16> head{};  // zeros beyond its end
};

struct Topic {
  std::string name;
  std::string type;  // package/Name, also in ROS 2, where it is package/msg/Name
  Serialization serialization = Serialization::kOther;
  std::vector<MessagePlace> messages;  // as they were recorded
};

// A file of messages that were recorded from topics. Not thread-safe.
class MessageLog {
 public:
  virtual ~MessageLog() = default;
  virtual const std::string& path() const = 0;
  virtual const std::vector<Topic>& topics() const = 0;
  // What is damaged or missing, though the rest can be read.
  virtual const std::vector<std::string>& warnings() const = 0;
  // The message's bytes. Throws InputError naming the file if they cannot be read.
  virtual std::string Read(const MessagePlace& place) const = 0;
};

// Each reads the file once, to find its messages, and throws InputError naming the file if it
// cannot be read, or is of another kind. A file that ends early or has damaged chunks is read as
// far as it goes, with a warning.

// ROS 1: bag format 2.0 (wiki.ros.org/Bags/Format/2.0), chunks plain or compressed by lz4 or bz2.
std::unique_ptr<MessageLog> OpenRosBag(const std::string& path);

// MCAP (mcap.dev/spec), with chunks or without, plain or compressed by lz4 or zstd; messages of
// ROS 1 and ROS 2.
std::unique_ptr<MessageLog> OpenMcap(const std::string& path);

// ROS 2's storage in SQLite; messages may be compressed by zstd one by one.
std::unique_ptr<MessageLog> OpenDb3(const std::string& path);

// All files of a ROS 2 bag's folder as one, which ends in `ending` (".db3" or ".mcap").
std::unique_ptr<MessageLog> OpenBagFolder(const std::string& folder, const std::string& ending);

// The type without /msg of ROS 2.
std::string PlainType(std::string type);

}  // namespace surfit
