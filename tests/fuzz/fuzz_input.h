#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace vildar::fuzz {

/// The bytes under test as a file in a folder of its own, in memory where the system has
/// /dev/shm. One file per process, overwritten by each call. Throws std::runtime_error where it
/// cannot be written.
std::filesystem::path file_with(const std::uint8_t* data, std::size_t size);

/// Ends the process, so that the input is kept, where a promise of a reader does not hold.
void require(bool holds, const char* promise);

}  // namespace vildar::fuzz

/// What libFuzzer and the replay of the corpora call for each input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
