#pragma once

#include "io/files/packed.h"
#include "io/files/places_file.h"
#include "surfit/loop_closure/keyframe.h"

namespace surfit {

// A view as bytes, and back. Throws InputError for one that is none.
void PutView(const PlaceView& view, Packer* packer);
PlaceView TakeView(PlacesPart part, Unpacker* unpacker);

}  // namespace surfit
