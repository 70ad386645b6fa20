#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "support/file_bytes.h"

namespace vildar::test {

/// Rewrites the stamp of a block of a Matroska file whose frames are all keyframes and whose
/// clusters start at 0. Throws std::runtime_error where the block is not found once.
inline void restamp(const std::filesystem::path& path, int from_ms, int to_ms) {
  std::string bytes = bytes_of(path);
  const auto block_head = [](int stamp_ms) {
    return std::string{'\x81', static_cast<char>(stamp_ms >> 8), static_cast<char>(stamp_ms),
                       '\x80'};
  };
  const std::size_t at = bytes.find(block_head(from_ms));
  if (at == std::string::npos || bytes.find(block_head(from_ms), at + 1) != std::string::npos)
    throw std::runtime_error("the block's stamp is not unique");
  bytes.replace(at, 4, block_head(to_ms));
  write_bytes(path, bytes);
}

}  // namespace vildar::test
