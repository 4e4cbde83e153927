#pragma once

#include "surfit/io/sequence.h"

namespace surfit::tools {

// The flags that say where the frames are and what camera took them; which of them to read (first,
// last, stride) is the program's own matter. Throws InputError naming the flag whose text is no
// list of numbers.
SequenceOptions SequenceOptionsFromFlags();

}  // namespace surfit::tools
