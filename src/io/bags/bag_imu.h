#pragma once

#include <memory>
#include <optional>
#include <string>

#include "io/bags/message_log.h"
#include "surfit/geometry/inertial.h"

namespace surfit {

// Opens a bag file, or a folder of a ROS 2 bag. `format`: bag, db3 or mcap. Throws InputError.
std::unique_ptr<MessageLog> OpenLog(const std::string& path, const std::string& format,
                                    bool is_folder);

// Reads the Imu topics of a bag, see ReadImu(). Returns std::nullopt without such a topic. The
// calibration has its defaults. Throws InputError with the path and the topics if several topics
// are possible, and for invalid messages.
std::optional<ImuRecording> ReadBagImu(const std::string& path, const std::string& format,
                                       bool is_folder);

}  // namespace surfit
