#pragma once

#include <string>
#include <string_view>

#include "types/result.h"

namespace vildar {

/// Text safe inside HTML elements and quoted attributes.
std::string escaped(std::string_view text);

/// A table cell; the label stands before it in narrow windows, where rows become cards.
std::string table_cell(std::string_view label, std::string_view css_class, const std::string& html);

/// The direction of travel with its colour.
std::string direction_words(Direction direction);

/// "52.2 ± 0.7" in km/h: as many digits as the uncertainty deserves.
std::string speed_words_kmh(const SpeedEstimate& speed);
/// "50.8 to 53.6" in km/h.
std::string interval_words_kmh(const SpeedEstimate& speed);

}  // namespace vildar
