#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vildar {

/// Throws ConfigError where `out` is one of the files or folders read, or an earlier file in such a
/// folder that this command would not have written: run.json, or not of its `extension`.
void refuse_to_replace(const std::filesystem::path& out, const std::string& extension,
                       const std::vector<std::filesystem::path>& read);

}  // namespace vildar
