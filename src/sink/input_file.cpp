#include <nettle/sha2.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/error.h"
#include "sink/run_summary.h"

namespace vildar {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 18;

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& fault) {
  throw InputError(path.string() + ": " + fault + "; give a regular file that can be read");
}

}  // namespace

InputFile describe_input(const std::string& role, const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw InputError(path.string() + ": no such file; check the name and the folder");
  if (std::filesystem::is_directory(path, error))
    throw InputError(path.string() + ": is a folder; name the file inside it");
  if (!std::filesystem::is_regular_file(path, error)) fail(path, "not a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(path, std::string("cannot be opened: ") + std::strerror(errno));

  sha256_ctx sha;  // takes the processor's own instructions where it has them
  sha256_init(&sha);
  InputFile input{role, path, 0, {}};
  std::vector<char> chunk(kChunkBytes);
  while (stream) {
    stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    const auto got_bytes = static_cast<std::size_t>(stream.gcount());
    sha256_update(&sha, got_bytes, reinterpret_cast<const std::uint8_t*>(chunk.data()));
    input.size_bytes += got_bytes;
  }
  if (stream.bad()) fail(path, "read failed after " + std::to_string(input.size_bytes) + " bytes");
  std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest;
  sha256_digest(&sha, digest.size(), digest.data());
  input.sha256 = hexadecimal(digest);
  return input;
}

}  // namespace vildar
