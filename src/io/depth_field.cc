#include "surfit/io/depth_field.h"

#include "io/sequence_camera.h"
#include "surfit/geometry/mirror.h"
#include "surfit/io/camera_yaml.h"

namespace surfit {

InverseDepthField ReadDepthField(const SequenceOptions& options, const std::string& format) {
  const std::string yaml = CameraFile(options, format);
  if (yaml.empty()) return {};
  const InverseDepthField field = ReadInverseDepthField(yaml);
  return ReadCameraYaml(yaml).depth.fy < 0 ? Mirrored(field) : field;
}

}  // namespace surfit
