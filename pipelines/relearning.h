#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "types/site.h"

namespace vildar {

/// The site with what it was before a calibration from runs learned it, where that has a std still;
/// what was written there as known since is. Learned from there, runs count once, and the errors of
/// what was learned, which go together, are not taken for independent.
Site before_learning(Site site, const std::optional<LearnedFrom>& learned);

/// SHA-256 of the clips that `runs` were given.
std::vector<std::string> clips_of(std::span<const std::filesystem::path> runs);

/// What a reader should know whose site file was learned from clips that are not among `clips`;
/// empty where all are.
std::string text_of_forgotten(const std::optional<LearnedFrom>& learned,
                              std::span<const std::string> clips);

}  // namespace vildar
