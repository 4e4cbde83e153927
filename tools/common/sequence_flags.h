#pragma once

#include "surfit/io/sequence.h"

namespace surfit::tools {

// The flags that say which frames to read, and with what camera. Throws InputError naming the flag
// whose text is no list of numbers.
SequenceOptions SequenceOptionsFromFlags();

}  // namespace surfit::tools
