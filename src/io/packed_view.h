#pragma once

#include "io/packed.h"
#include "surfit/io/places_file.h"
#include "surfit/places/keyframe.h"

namespace surfit {

// A view as bytes, and back. Throws InputError for one that is none.
void PutView(const PlaceView& view, Packer* packer);
PlaceView TakeView(PlacesPart part, Unpacker* unpacker);

}  // namespace surfit
