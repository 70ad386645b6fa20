#pragma once

#include <string_view>

#include "core/outcome.h"
#include "types/result.h"

namespace vildar {

/// Why a speed is not given, as one sentence for people.
std::string_view sentence_for(Miss miss);

/// A method's name in words.
std::string_view words_for(Method method);

}  // namespace vildar
