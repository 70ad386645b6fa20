#pragma once

#include <span>
#include <string>
#include <vector>

namespace vildar {

/// What of a run's warnings a person reads: of those that differ in numbers alone the first three,
/// and how many more there are. In the order in which each kind first comes.
std::vector<std::string> terminal_warnings(std::span<const std::string> warnings);

}  // namespace vildar
