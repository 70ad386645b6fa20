#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "types/site.h"

namespace vildar {

/// The site with what it said before a calibration from runs learned it. Learned from there, runs
/// count once, and the errors of what was learned, which go together, are not taken for
/// independent. What was written since in the place of what was learned stays; quantities that the
/// site no longer has are named in `warnings`.
Site before_learning(Site site, const std::optional<LearnedFrom>& learned,
                     std::vector<std::string>& warnings);

/// What a site says now of a quantity that a calibration learns, in the unit of its key.
std::optional<Uncertain> said_of(const std::string& key, const Site& site);

/// SHA-256 of the clips that `runs` were given.
std::vector<std::string> clips_of(std::span<const std::filesystem::path> runs);

/// Adds what a reader should know whose site file was learned from clips that are not among
/// `clips`.
void warn_of_forgotten(const std::optional<LearnedFrom>& learned,
                       std::span<const std::string> clips, std::vector<std::string>& warnings);

}  // namespace vildar
