#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "types/site.h"

namespace vildar {

/// The site of a camera that stands still; throws ConfigError where it has none, or one that
/// drives.
Site load_fixed_site(const std::filesystem::path& file);

/// Throws ConfigError where a run is given twice: its passes would count twice.
void refuse_repeated(std::span<const std::filesystem::path> runs);

/// A share as a report shows it, e.g. "2.70 %".
std::string percent_text(double share);

}  // namespace vildar
