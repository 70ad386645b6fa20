#pragma once

#include <cstdlib>
#include <filesystem>

namespace vildar {

/// The folder of reference data that is too large or not free enough for the repository:
/// $VILDAR_SHARED, or `shared` beside the source folder. It may be absent; a test that needs it
/// then skips.
inline std::filesystem::path shared_folder() {
  if (const char* told = std::getenv("VILDAR_SHARED")) return told;
  return std::filesystem::path(VILDAR_SOURCE_DIR).parent_path() / "shared";
}

}  // namespace vildar
