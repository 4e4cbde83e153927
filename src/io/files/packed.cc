#include "io/files/packed.h"

namespace surfit {

void PutView(const PlaceView& view, Packer* packer) {
  const PinholeCamera& camera = view.camera;
  packer->Put(camera.width);
  packer->Put(camera.height);
  for (const double number : {camera.fx, camera.fy, camera.cx, camera.cy}) packer->Put(number);
  packer->Put(view.noise.inverse_depth_sigma);
  packer->PutImage(view.depth);
  packer->PutImage(view.intensity);
  packer->PutCount(view.features.size());
  for (const PlaceFeature& feature : view.features) {
    for (const float number : feature.point) packer->Put(number);
    for (const std::uint64_t bits : feature.descriptor) packer->Put(bits);
  }
}

PlaceView TakeView(PlacesPart part, Unpacker* unpacker) {
  PlaceView view;
  PinholeCamera& camera = view.camera;
  camera.width = unpacker->Take<int>();
  camera.height = unpacker->Take<int>();
  for (double* number : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    *number = unpacker->Take<double>();
  }
  view.noise.inverse_depth_sigma = unpacker->Take<double>();
  view.depth = unpacker->TakeImage<std::uint16_t>(part == PlacesPart::kAll);
  view.intensity = unpacker->TakeImage<std::uint8_t>(part == PlacesPart::kAll);
  view.features.resize(unpacker->TakeCount(3 * sizeof(float) + sizeof(BinaryDescriptor)));
  for (PlaceFeature& feature : view.features) {
    for (float& number : feature.point) number = unpacker->Take<float>();
    for (std::uint64_t& bits : feature.descriptor) bits = unpacker->Take<std::uint64_t>();
  }
  if (view.depth.empty()) return view;
  const bool fits = view.depth.width() == camera.width && view.depth.height() == camera.height &&
                    (view.intensity.empty() || view.intensity.size() == view.depth.size());
  if (!fits || !(camera.fx > 0) || !(camera.fy > 0) || !(view.noise.inverse_depth_sigma > 0)) {
    unpacker->Fail("has a view with an invalid camera");
  }
  return view;
}

void PutField(const InverseDepthField& field, Packer* packer) {
  for (const double coefficient : field.coefficients) packer->Put(coefficient);
}

InverseDepthField TakeField(Unpacker* unpacker) {
  InverseDepthField field;
  for (double& coefficient : field.coefficients) {
    coefficient = unpacker->Take<double>();
    if (!std::isfinite(coefficient)) unpacker->Fail("has an invalid depth correction");
  }
  return field;
}

}  // namespace surfit
