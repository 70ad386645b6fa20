#include "core/error.h"
#include "fuzz/fuzz_input.h"
#include "synth/scenario.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    vildar::load_scenario(vildar::fuzz::file_with(data, size));
  } catch (const vildar::ConfigError& error) {
    vildar::fuzz::require(!error.problems().empty(), "a refusal says what is wrong");
  }
  return 0;
}
