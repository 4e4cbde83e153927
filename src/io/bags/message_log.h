#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace surfit {

// Serialisation of messages: ROS 1, or CDR (Common Data Representation, OMG) of ROS 2.
enum class Serialization { kRos1, kCdr, kOther };

// Position of a message in the file, and its first bytes, which contain the timestamp.
struct MessageLocation {
  std::int64_t recorded_ns = 0;  // recording time, clock of the recorder
  int part = -1;  // chunk with the message; -1: not in a chunk; folder: number of file and chunk
  std::uint64_t at = 0;         // position of the first byte in the part; SQLite: row id
  std::uint64_t size = 0;       // bytes as stored; SQLite: maybe compressed
  std::array<char, 16> head{};  // first bytes after decompression, padded with zeros
};

// Messages of one name, type and serialization.
struct Topic {
  std::string name;
  std::string type;  // package/Name, also for package/msg/Name of ROS 2
  Serialization serialization = Serialization::kOther;
  std::vector<MessageLocation> messages;  // in file order
};

// Bag file: recorded messages of topics. The file must not change. Not thread-safe.
class MessageLog {
 public:
  virtual ~MessageLog() = default;
  virtual const std::string& path() const = 0;
  // Valid as long as the log.
  virtual const std::vector<Topic>& topics() const = 0;
  // Descriptions of damaged or missing parts that were skipped.
  virtual const std::vector<std::string>& warnings() const = 0;
  // Bytes of a message of this log, after decompression. Throws InputError with the path if the
  // message cannot be read.
  virtual std::string Read(const MessageLocation& place) const = 0;
};

// The functions below read the file once to index its messages. They throw InputError with the path
// if the file cannot be read or has another format. Damaged chunks and a missing end are skipped
// with a warning. Damaged records outside of chunks and damaged SQLite files are errors.

// ROS 1 bag, format 2.0 (wiki.ros.org/Bags/Format/2.0). Chunk compression: none, lz4 or bz2.
std::unique_ptr<MessageLog> OpenRosBag(const std::string& path);

// MCAP (mcap.dev/spec) with or without chunks, messages of ROS 1 or ROS 2. Chunk compression: none,
// lz4 or zstd.
std::unique_ptr<MessageLog> OpenMcap(const std::string& path);

// SQLite bag of ROS 2. Messages may be compressed with zstd individually.
std::unique_ptr<MessageLog> OpenDb3(const std::string& path);

// Folder of a ROS 2 bag: all files with `ending` (".db3" or ".mcap") as one log, in the order of
// their names. Throws InputError without such a file.
std::unique_ptr<MessageLog> OpenBagFolder(const std::string& folder, const std::string& ending);

// Message type without "/msg" of ROS 2.
std::string PlainType(std::string type);

}  // namespace surfit
